//! Options by name: what the command line, Python and files say, and what goes together.

use super::method::SamplesOfPixel;
use super::schema::{RENDER, Value, parsed};
use super::{Interpolation, Method, PictureOptions, RenderOptions};
use crate::Error;

impl RenderOptions {
    /// Returns the options with these values, which [`About::read`](super::schema::About::read) has returned, and the defaults for the rest. With a
    /// time limit and no number of samples, there are as many as there is time for; where nothing is said of samples, up to
    /// 64 where there is noise. Without a method it is `auto`, and `mesh` where single lights cannot be read.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for an error, or a quality, of another method than `auto`, or both. Other options that the method
    /// does not have do nothing.
    pub fn chosen<'a>(values: impl Fn(&str) -> Option<&'a Value>) -> Result<Self, Error> {
        // The method first: others are kept in it.
        let method = match values("method") {
            Some(name) => Method::named(name.as_text()).unwrap_or_default(),
            None if values("interpolation").is_none_or(reads_single_lights) => Method::AUTO,
            None => Method::MESH,
        };
        let mut options = Self { method, ..Self::default() };
        let others = RENDER.iter().filter(|entry| entry.about.name != "method");
        for (entry, value) in others.filter_map(|entry| Some((entry, values(entry.about.name)?))) {
            (entry.set)(&mut options, value);
        }

        // Samples, as they go with the method, and what does not go with it.
        let SamplesOfPixel { spp, most_spp, near_rays } = SamplesOfPixel::of(options.method);
        if values("near-rays").is_none() {
            options.mesh.near_rays = near_rays;
        }
        match (values("spp"), values("time-limit"), values("most-spp")) {
            (None, None, most) => {
                options.picture.spp = spp;
                options.picture.most_spp = options.picture.most_spp.filter(|_| most.is_some()).or(Some(most_spp));
            }
            (None, Some(_), _) => options.picture.spp = PictureOptions::MOST_SPP,
            _ => {}
        }
        let refused = match (values("error"), values("quality")) {
            (Some(_), Some(_)) => Some(("quality", "is an error by name: give one of them")),
            (Some(_), _) if options.method.error().is_none() => {
                Some(("error", "is kept to by the methods auto and mesh alone"))
            }
            (_, Some(_)) if !matches!(options.method, Method::Auto { .. }) => {
                Some(("quality", "is kept to by the method auto alone"))
            }
            _ => None,
        };
        if let Some((option, what)) = refused {
            return Err(Error::InvalidOption { option, what: what.into() });
        }
        Ok(options)
    }
}

/// Whether single lights can be read by an interpolation of this name.
fn reads_single_lights(name: &Value) -> bool {
    let unread = |way| matches!(way, Interpolation::Sphere { .. } | Interpolation::TrilinearWith(_));
    !unread(parsed::<Interpolation>(name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::named;

    #[test]
    fn values_by_name_become_options() {
        let choose = |pairs: &[(&str, &str)]| {
            let read = |(name, text): &(&str, &str)| {
                let entry = named(name).expect("an option");
                (entry.about.name, entry.about.read(&Value::text(text)).expect("a value"))
            };
            let values: Vec<(&str, Value)> = pairs.iter().map(read).collect();
            RenderOptions::chosen(|name| values.iter().find(|(key, _)| *key == name).map(|(_, value)| value))
        };
        let defaults = RenderOptions::default().with(|o| (o.method, o.picture.most_spp) = (Method::AUTO, Some(64)));
        assert_eq!(choose(&[]).expect("defaults"), defaults);
        assert_eq!(choose(&[("spp", "4"), ("method", "mesh")]).expect("options"), RenderOptions::default());
        let preview = choose(&[("quality", "preview")]).expect("options");
        assert_eq!((preview.method, preview.picture.spp, preview.mesh.near_rays), (Method::with_error(0.1), 2, 8));
        assert_eq!(choose(&[("interpolation", "sphere")]).expect("options").method, Method::MESH);
        let mesh = choose(&[("method", "mesh"), ("error", "0.1")]).expect("options");
        assert_eq!(mesh.method, Method::Mesh { error: Some(0.1) });
        assert!(choose(&[("error", "0.1"), ("quality", "final")]).is_err());
        assert!(choose(&[("quality", "final"), ("method", "hybrid")]).is_err());
        let options = choose(&[("rays", "8"), ("method", "unbiased"), ("time-limit", "2")]).expect("options");
        assert_eq!((options.method, options.picture.spp), (Method::unbiased(8), 65536));
        let options = choose(&[("time-limit", "2"), ("spp", "8"), ("graded", "2.5")]).expect("options");
        assert_eq!((options.picture.spp, options.mesh.lod_distance), (8, Some(2.5)));
        assert!(choose(&[("error", "0.1"), ("method", "path")]).is_err());
    }
}
