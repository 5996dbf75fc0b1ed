//! Contents of the files that a recipe names: triangles of a part, a measured log, the picture or the stack that boards
//! are cut from. Each is read once, with the recipe, and shared by all samples.

use std::sync::Arc;

use base::Mesh;
use procedural::wood::Stem;
use wood_picture::{BoardPicture, WoodVolume};

use crate::asset::AssetFault;
use crate::keys::setting_type::NamedFile;
use crate::keys::settings::Settings;
use crate::subject::Subject;
use crate::{measured_log, mesh, picture, slices, texture};
use optical_bench::settings::{LineShape, LogSource, TextureImage};
use yaml::YamlReader;

/// The objects that files give; none where the recipe needs no such file, or where the file is at fault.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FileContents {
    /// Triangles of a part.
    pub mesh: Option<Arc<Mesh>>,
    /// The log that was measured.
    pub measured: Option<Arc<Stem>>,
    /// The picture that boards are cut from.
    pub picture: Option<Arc<BoardPicture>>,
    /// The stack of slices that they are cut from.
    pub slices: Option<Arc<WoodVolume>>,
    /// The picture that a projector throws.
    pub texture: Option<TextureImage>,
}

impl FileContents {
    /// Of the files that `settings` name and have loaded; faults are noted at their keys.
    pub fn read(yaml: &mut YamlReader, subject: Option<Subject>, settings: &Settings) -> Self {
        let (file, log) = (&settings.mesh.file, &settings.log);
        let mesh = file.asset().map(|file| mesh::read_mesh(file).map_err(|fault| ("mesh.file", fault)));
        let measured = match [&log.pith_file, &log.radii_file, &log.knots_file].map(NamedFile::asset) {
            [Some(pith), Some(radii), Some(knots)] => Some(measured_log::read_log([pith, radii, knots])),
            _ => None,
        };
        let asked = |source| subject == Some(Subject::Wood) && log.source == source;
        let picture = asked(LogSource::Picture).then(|| picture::read_picture(&settings.picture));
        // What follows from a default in the place of a setting at fault is no fault of its own.
        let slices = asked(LogSource::Slices) && !yaml.has_fault_of("slices");
        let slices = slices.then(|| slices::read_slices(&settings.slices));
        let texture = settings.laser.texture.asset().filter(|_| settings.laser.profile == LineShape::Texture);
        let texture = texture.map(|file| texture::read(file).map_err(|fault| ("laser.texture", fault)));
        Self {
            mesh: mesh.and_then(|read| told(yaml, read)).map(Arc::new),
            measured: measured.and_then(|read| told(yaml, read)).map(Arc::new),
            picture: picture.and_then(|read| told(yaml, read)?).map(Arc::new),
            slices: slices.and_then(|read| told(yaml, read)?).map(Arc::new),
            texture: texture.and_then(|read| told(yaml, read)),
        }
    }
}

/// What was read; a fault is noted at its key.
fn told<T>(yaml: &mut YamlReader, read: Result<T, (&'static str, AssetFault)>) -> Option<T> {
    read.map_err(|(key, fault)| yaml.joint_fault(&[key], fault.problem, fault.remedy)).ok()
}
