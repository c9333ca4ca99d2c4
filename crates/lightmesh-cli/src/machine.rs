//! What the machine has.

use std::{fs, path::Path, sync::OnceLock};

use lightmesh::Limits;
use sysinfo::{MemoryRefreshKind, RefreshKind, System};

/// Returns the memory of the machine, or of the control group that the process is in, bytes; `None` where the system does
/// not tell.
pub(crate) fn memory() -> Option<u64> {
    static MEMORY: OnceLock<Option<u64>> = OnceLock::new();
    *MEMORY.get_or_init(|| {
        let kind = RefreshKind::nothing().with_memory(MemoryRefreshKind::nothing().with_ram());
        let machine = System::new_with_specifics(kind).total_memory();
        let group = fs::read_to_string("/proc/self/cgroup").ok().and_then(|groups| {
            least_limit(&groups, |file| fs::read_to_string(Path::new("/sys/fs/cgroup").join(file)).ok())
        });
        [machine, group.unwrap_or(machine)].into_iter().filter(|&bytes| bytes > 0).min()
    })
}

/// Returns the limit of memory where none is chosen: half of [`memory`], or the library's where that is unknown.
pub(crate) fn default_limit() -> u64 {
    memory().map_or(Limits::default().max_memory, |bytes| bytes / 2)
}

/// The least limit of the control groups, of version 2 or 1, that a process is in, and of those above them: batch systems
/// set them far down. `groups` is /proc/self/cgroup, `read` reads a file below /sys/fs/cgroup.
fn least_limit(groups: &str, read: impl Fn(&str) -> Option<String>) -> Option<u64> {
    let limits = groups.lines().filter_map(|line| {
        // hierarchy:controllers:path, the controllers empty in version 2.
        let mut parts = line.splitn(3, ':').skip(1);
        let (controllers, path) = (parts.next()?, parts.next()?);
        let (folder, file) = match controllers {
            "" => ("", "memory.max"),
            list if list.split(',').any(|controller| controller == "memory") => ("memory", "memory.limit_in_bytes"),
            _ => return None,
        };
        // The group's own, and those above it.
        let above = Path::new(path.trim_start_matches('/')).ancestors();
        let limits = above.filter_map(|group| {
            let file = Path::new(folder).join(group).join(file);
            // "max": no limit.
            read(file.to_str()?)?.trim().parse::<u64>().ok()
        });
        limits.min()
    });
    limits.min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_limit_on_the_way_up_counts() {
        let files = [
            ("job/step/memory.max", "max\n"),
            ("job/memory.max", "8000\n"),
            ("memory.max", "9000\n"),
            ("memory/a/memory.limit_in_bytes", "9223372036854771712\n"),
            ("memory/memory.limit_in_bytes", "7000\n"),
        ];
        let read = |name: &str| files.iter().find(|(file, _)| *file == name).map(|(_, text)| (*text).to_owned());
        assert_eq!(least_limit("0::/job/step\n", read), Some(8000));
        assert_eq!(least_limit("11:cpu,memory:/a\n0::/\n", read), Some(7000));
        assert_eq!(least_limit("3:cpu:/job\n", read), None);
    }

    #[test]
    fn a_machine_has_memory() {
        assert!(memory().is_none_or(|bytes| bytes > 1 << 20));
        assert!(default_limit() > 0);
    }
}
