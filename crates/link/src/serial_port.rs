//! Owns the list of this machine's serial ports: which there are, what is plugged in, and whether a link can open them.

use std::path::{Path, PathBuf};

use serial2_tokio::SerialPort as Device;

use crate::address::{DEFAULT_BAUD, DEFAULT_USB_BAUD, default_baud};

/// Baud rate of a UART of this machine's own, as between a companion computer and the autopilot.
pub const COMPANION_BAUD: u32 = 921_600;

/// Most characters of a description.
const MAX_DESCRIPTION: usize = 80;

/// A serial port of this machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SerialPort {
    /// Its device: `/dev/ttyUSB0`, `COM3`.
    pub device: String,
    /// A name that stays when the number of the device changes: in `/dev/serial/by-id`, or `/dev/serial0` of a Raspberry
    /// Pi.
    pub lasting_path: Option<String>,
    /// Manufacturer and product, as a USB device says.
    pub description: Option<String>,
    /// Baud rate that is usual there: [`DEFAULT_USB_BAUD`] for an autopilot's own USB, [`DEFAULT_BAUD`] for an adapter,
    /// behind which is mostly a radio, [`COMPANION_BAUD`] for any other.
    pub usual_baud: u32,
    /// Whether a program has locked it, this one included. Only Linux tells; not every program locks.
    pub is_in_use: bool,
    /// Whether this process may open it.
    pub is_allowed: bool,
}

impl SerialPort {
    /// Whether a path names this port.
    pub fn is_at(&self, path: &str) -> bool {
        path == self.device || std::fs::canonicalize(path).is_ok_and(|device| device == Path::new(&self.device))
    }
}

/// The serial ports of this machine: autopilots on USB first, then adapters, then the others.
pub fn serial_ports() -> Vec<SerialPort> {
    let devices = Device::available_ports().unwrap_or_default();
    // A Mac lists each port twice; opening its `tty` waits for a carrier.
    let is_waiting = |device: &PathBuf| name_of(device).starts_with("tty.");
    listed(devices.into_iter().filter(|device| !is_waiting(device)), Path::new("/"))
}

/// `root`: the folder that has `sys`, `dev`, `proc` and `run`.
fn listed(devices: impl IntoIterator<Item = PathBuf>, root: &Path) -> Vec<SerialPort> {
    let names = lasting_names(root);
    let locks = std::fs::read_to_string(root.join("proc/locks")).unwrap_or_default();
    let described = |device: PathBuf| {
        let name = name_of(&device);
        SerialPort {
            lasting_path: names.iter().find(|(_, named)| *named == device).map(|(path, _)| text(path)),
            description: description(root, name),
            usual_baud: baud_of(name),
            is_in_use: is_locked(&device, &locks) || has_lock_file(root, name),
            is_allowed: may_open(&device),
            device: text(&device),
        }
    };
    let mut ports: Vec<_> = devices.into_iter().map(described).collect();
    let rank = |port: &SerialPort| [DEFAULT_USB_BAUD, DEFAULT_BAUD].iter().position(|baud| *baud == port.usual_baud);
    // By length first, so that 10 comes after 9.
    ports.sort_by_cached_key(|port| (rank(port).unwrap_or(usize::MAX), port.device.len(), port.device.clone()));
    ports
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

fn name_of(device: &Path) -> &str {
    device.file_name().and_then(|name| name.to_str()).unwrap_or_default()
}

fn baud_of(name: &str) -> u32 {
    let is_own = ["ttyS", "ttyAMA", "ttyTHS", "ttyHS", "ttymxc", "ttyO"].iter().any(|uart| name.starts_with(uart));
    if is_own { COMPANION_BAUD } else { default_baud(name) }
}

/// Names that stay, and the device of each.
fn lasting_names(root: &Path) -> Vec<(PathBuf, PathBuf)> {
    let by_id = std::fs::read_dir(root.join("dev/serial/by-id")).into_iter().flatten();
    let mut names: Vec<_> = by_id.filter_map(|entry| Some(entry.ok()?.path())).collect();
    names.sort_unstable();
    names.extend(["dev/serial0", "dev/serial1"].map(|alias| root.join(alias)));
    let with_device = |path: PathBuf| std::fs::canonicalize(&path).ok().map(|device| (path, device));
    names.into_iter().filter_map(with_device).collect()
}

/// The texts of the USB device that a port belongs to.
fn description(root: &Path, name: &str) -> Option<String> {
    let interface = std::fs::canonicalize(root.join("sys/class/tty").join(name).join("device")).ok()?;
    let usb = interface.ancestors().take(4).find(|folder| folder.join("product").is_file())?;
    let read = |file: &str| -> Option<String> {
        let told = std::fs::read(usb.join(file)).ok()?;
        let told = String::from_utf8_lossy(&told);
        let plain = told.trim().chars().filter(|letter| !letter.is_control()).take(MAX_DESCRIPTION);
        Some(plain.collect()).filter(|plain: &String| !plain.is_empty())
    };
    let product = read("product")?;
    let maker = read("manufacturer").filter(|maker| !product.contains(maker.as_str()));
    Some(maker.map_or(product.clone(), |maker| format!("{maker} {product}")))
}

/// Whether the kernel's list of locks has this device.
#[cfg(target_os = "linux")]
fn is_locked(device: &Path, locks: &str) -> bool {
    use std::os::unix::fs::MetadataExt;
    let Ok(file) = device.metadata() else { return false };
    let (major, minor) = (rustix::fs::major(file.dev()), rustix::fs::minor(file.dev()));
    let inode = format!("{major:02x}:{minor:02x}:{}", file.ino());
    locks.lines().any(|lock| lock.split_whitespace().any(|word| word == inode))
}

#[cfg(not(target_os = "linux"))]
fn is_locked(_: &Path, _: &str) -> bool {
    false
}

/// Whether a running program has the lock file that terminals and Qt (QGroundControl) make.
fn has_lock_file(root: &Path, name: &str) -> bool {
    let Ok(lock) = std::fs::read_to_string(root.join("run/lock").join(format!("LCK..{name}"))) else { return false };
    let process = lock.split_whitespace().next().and_then(|id| id.parse::<u32>().ok());
    process.is_some_and(|id| root.join("proc").join(id.to_string()).exists())
}

#[cfg(unix)]
fn may_open(device: &Path) -> bool {
    use rustix::fs::{Access, access};
    access(device, Access::READ_OK | Access::WRITE_OK).is_ok()
}

#[cfg(not(unix))]
fn may_open(_: &Path) -> bool {
    true
}

#[cfg(target_os = "linux")]
#[cfg(test)]
mod tests {
    use std::fs::{create_dir_all, write};
    use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};

    use super::*;
    use crate::testing::TempDir;

    fn named<'a>(ports: &'a [SerialPort], name: &str) -> &'a SerialPort {
        ports.iter().find(|port| port.device.ends_with(name)).unwrap()
    }

    #[test]
    fn ports_are_described_as_linux_tells_of_them() {
        let folder = TempDir::new();
        let root = std::fs::canonicalize(&folder.0).unwrap();
        create_dir_all(root.join("dev/serial/by-id")).unwrap();
        create_dir_all(root.join("run/lock")).unwrap();
        let devices = ["ttyS0", "ttyUSB10", "ttyUSB9", "ttyACM0", "ttyAMA0"].map(|name| root.join("dev").join(name));
        for device in &devices {
            write(device, "").unwrap();
        }
        symlink("../../ttyACM0", root.join("dev/serial/by-id/usb-Hex_CubeOrange_1-if00")).unwrap();
        symlink("ttyAMA0", root.join("dev/serial0")).unwrap();
        let usb = root.join("sys/devices/usb1/1-2");
        for (interface, name) in [("1-2:1.0", "ttyACM0"), ("1-2:1.1/ttyUSB9", "ttyUSB9")] {
            create_dir_all(usb.join(interface)).unwrap();
            create_dir_all(root.join("sys/class/tty").join(name)).unwrap();
            symlink(usb.join(interface), root.join("sys/class/tty").join(name).join("device")).unwrap();
        }
        write(usb.join("manufacturer"), "Hex\n").unwrap();
        write(usb.join("product"), "Cube\u{1b}Orange\n").unwrap();
        let inode = |name: &str| {
            let file = root.join("dev").join(name).metadata().unwrap();
            let (major, minor) = (rustix::fs::major(file.dev()), rustix::fs::minor(file.dev()));
            format!("{major:02x}:{minor:02x}:{}", file.ino())
        };
        create_dir_all(root.join("proc/71")).unwrap();
        let locks = format!(
            "1: FLOCK  ADVISORY  WRITE 71 {} 0 EOF\n2: POSIX  ADVISORY  READ 9 00:1a:1 0 EOF\n",
            inode("ttyUSB9")
        );
        write(root.join("proc/locks"), locks).unwrap();
        write(root.join("run/lock/LCK..ttyACM0"), "        71\nQGroundControl\nfield\n").unwrap();
        write(root.join("run/lock/LCK..ttyS0"), "        72\n").unwrap();

        let ports = listed(devices, &root);
        let order: Vec<_> = ports.iter().map(|port| name_of(Path::new(&port.device))).collect();
        assert_eq!(order, ["ttyACM0", "ttyUSB9", "ttyUSB10", "ttyS0", "ttyAMA0"]);
        let bauds: Vec<_> = ports.iter().map(|port| port.usual_baud).collect();
        assert_eq!(bauds, [115_200, 57_600, 57_600, 921_600, 921_600]);
        let cube = named(&ports, "ttyACM0");
        assert_eq!(cube.description.as_deref(), Some("Hex CubeOrange"));
        assert!(cube.lasting_path.as_deref().unwrap().ends_with("by-id/usb-Hex_CubeOrange_1-if00"), "{cube:?}");
        assert!(cube.is_at(cube.lasting_path.as_deref().unwrap()) && cube.is_at(&cube.device));
        assert!(!cube.is_at(&named(&ports, "ttyS0").device));
        assert_eq!(named(&ports, "ttyUSB9").description.as_deref(), Some("Hex CubeOrange"), "a folder deeper");
        assert_eq!(named(&ports, "ttyUSB10").description, None);
        assert!(named(&ports, "ttyAMA0").lasting_path.as_deref().unwrap().ends_with("dev/serial0"));
        let in_use: Vec<_> =
            ports.iter().filter(|port| port.is_in_use).map(|port| name_of(Path::new(&port.device))).collect();
        assert_eq!(in_use, ["ttyACM0", "ttyUSB9"], "the program of the other lock file has ended");
    }

    #[test]
    fn a_port_of_another_group_is_not_allowed() {
        let folder = TempDir::new();
        let device = folder.0.join("ttyUSB0");
        write(&device, "").unwrap();
        std::fs::set_permissions(&device, std::fs::Permissions::from_mode(0o000)).unwrap();
        let is_root = rustix::process::geteuid().is_root();
        assert_eq!(listed([device], &folder.0)[0].is_allowed, is_root);
    }
}
