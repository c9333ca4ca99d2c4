//! `--aov`.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use lightmesh::Aov;

/// Parses the name of a layer; clap splits the list and says which names there are.
pub(super) fn parser() -> impl TypedValueParser<Value = Aov> {
    PossibleValuesParser::new(Aov::ALL.map(Aov::name)).try_map(|name| Aov::named(&name).ok_or("unknown layer"))
}
