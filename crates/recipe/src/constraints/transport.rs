//! Constraint between the model of light and the objects that it knows.

use crate::keys::settings::Settings;
use crate::subject::Subject;
use bench::settings::TransportName;
use yaml::YamlReader;

/// Whether a model can spread light in such objects: those that need one medium without air know no pack, and all but the
/// kernel ask for a height field, which a mesh need not be.
fn knows(model: TransportName, subject: Subject) -> bool {
    match subject {
        Subject::Wood | Subject::Sawtooth => true,
        Subject::Blister => matches!(model, TransportName::Kernel | TransportName::Path),
        Subject::Mesh => model == TransportName::Kernel,
    }
}

/// The model that is chosen can spread light in the recipe's objects.
pub(super) fn check(yaml: &mut YamlReader, subject: Option<Subject>, settings: &Settings) {
    let model = settings.transport.model;
    if let Some(subject) = subject.filter(|subject| !knows(model, *subject)) {
        let keys = ["transport.model".to_owned(), "transport".to_owned()];
        let (lack, remedy) = match subject {
            Subject::Mesh => ("no part that overhangs", "give `kernel`"),
            Subject::Wood | Subject::Blister | Subject::Sawtooth => {
                ("no film over air", "give `kernel`, or `path` for single profiles")
            }
        };
        yaml.joint_fault(
            &keys,
            format!("`{}` knows {lack}, and the subject is `{}`", model.name(), subject.name()),
            remedy,
        );
    }
}

/// The names of the models that can spread light in objects of `subject`.
pub(crate) fn models(subject: Subject) -> Vec<&'static str> {
    TransportName::ALL.into_iter().filter(|model| knows(*model, subject)).map(TransportName::name).collect()
}
