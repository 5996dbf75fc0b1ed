//! A small disk of its own, in memory, which only root can mount.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Set to 1 it says that this machine mounts no disks, so that tests of full disks are left out.
const NO_DISK: &str = "SHEETLIGHT_NO_DISK";

/// A mounted disk; unmounted at the end.
pub struct Disk(PathBuf);

impl Disk {
    /// Mounts a tmpfs with these options (`size=2m`) in an empty folder. `None` where `SHEETLIGHT_NO_DISK=1` says that
    /// this machine mounts none; where none can be mounted otherwise, the test fails.
    pub fn mount(folder: &Path, options: &str) -> Option<Self> {
        if std::env::var_os(NO_DISK).is_some_and(|set| set == "1") {
            eprintln!("not tested: {NO_DISK}=1");
            return None;
        }
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", options, "tmpfs"]).arg(folder).output();
        let told = |output: Output| match output.status.success() {
            true => Ok(()),
            false => Err(String::from_utf8_lossy(&output.stderr).trim().to_owned()),
        };
        if let Err(why) = mounted.map_err(|e| e.to_string()).and_then(told) {
            panic!("no small disk can be mounted ({why}): run this test as root, or leave it out with {NO_DISK}=1");
        }
        Some(Self(folder.to_owned()))
    }

    /// Where it is mounted.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Makes it as large as that [MB].
    pub fn grow(&self, megabytes: u32) {
        let size = format!("remount,size={megabytes}m");
        assert!(Command::new("mount").args(["-o", &size]).arg(&self.0).status().expect("mount starts").success());
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg("-l").arg(&self.0).status();
    }
}
