//! How much memory this process may use, as the system says.

use std::fs;
use std::path::Path;

/// Where the system says nothing: 4 GiB.
const UNKNOWN: u64 = 4 << 30;
/// Limits above this are none.
const NO_LIMIT: u64 = 1 << 60;

/// The least of the machine's memory, the limits of its control groups and that of the address space, bytes.
pub(super) fn memory() -> u64 {
    let groups = read("/proc/self/cgroup");
    let limits = [
        total(&read("/proc/meminfo")),
        address_space(&read("/proc/self/limits")),
        group_limit(&groups, &|file| fs::read_to_string(file).ok()),
    ];
    limits.into_iter().flatten().min().unwrap_or(UNKNOWN)
}

fn read(path: &str) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

/// `MemTotal` of /proc/meminfo.
fn total(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}

/// The soft limit of the address space of /proc/self/limits.
fn address_space(limits: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// The least limit of the control groups of /proc/self/cgroup and of those above them; `file` reads a file.
fn group_limit(groups: &str, file: &dyn Fn(&Path) -> Option<String>) -> Option<u64> {
    let of_line = |line: &str| {
        let mut parts = line.splitn(3, ':').skip(1);
        let (controllers, group) = (parts.next()?, parts.next()?);
        let (root, name) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            _ if controllers.split(',').any(|c| c == "memory") => {
                ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
            }
            _ => return None,
        };
        let folder = Path::new(root).join(group.trim_start_matches('/'));
        // Within a container the group may be seen as the root.
        let folders = folder.ancestors().take_while(|folder| folder.starts_with(root));
        folders.filter_map(|folder| file(&folder.join(name))?.trim().parse::<u64>().ok()).min()
    };
    groups.lines().filter_map(of_line).filter(|&limit| limit < NO_LIMIT).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_systems_files_are_understood() {
        assert_eq!(total("MemFree: 1 kB\nMemTotal:       16384 kB\n"), Some(16 << 20));
        assert_eq!(address_space("Max address space  2147483648  unlimited  bytes\n"), Some(2 << 30));
        assert_eq!(address_space("Max address space  unlimited  unlimited  bytes\n"), None);
        assert!(memory() > 1 << 20);
    }

    #[test]
    fn the_least_limit_of_a_group_and_those_above_it_counts() {
        let file = |path: &Path| match path.to_str()? {
            "/sys/fs/cgroup/a/b/memory.max" => Some("max\n".into()),
            "/sys/fs/cgroup/a/memory.max" => Some("1000000\n".into()),
            "/sys/fs/cgroup/memory/c/memory.limit_in_bytes" => Some("2000000\n".into()),
            "/sys/fs/cgroup/memory/memory.limit_in_bytes" => Some("9223372036854771712\n".into()),
            _ => None,
        };
        assert_eq!(group_limit("0::/a/b\n", &file), Some(1_000_000));
        assert_eq!(group_limit("5:cpu,memory:/c\n1:cpu:/a\n", &file), Some(2_000_000));
        assert_eq!(group_limit("5:memory:/elsewhere\n", &file), None);
    }
}
