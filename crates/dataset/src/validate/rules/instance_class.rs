//! Every pixel of an instance has the class of its object, and every other one is ground.

use base::{Class, ClassKind};

use super::{Code, REMAKE_OR_REPORT, Rule, SampleToCheck, ValidationReport};

pub(super) const RULE: Rule = Rule {
    meaning: "A pixel has another class than its instance, or an instance where there is none.",
    remedy: REMAKE_OR_REPORT,
};

pub(super) fn check(sample: &SampleToCheck, report: &mut ValidationReport) {
    let SampleToCheck { row, images: decoded, place, .. } = sample;
    let (Some(label), Some(instance)) = (decoded.get("label"), decoded.get("instance")) else { return };
    let ground = |class: u16| Class::of(class).is_some_and(|class| class.kind() == ClassKind::Ground);
    // No class is as large: an instance without an object is told by another rule.
    let numbers = row.objects.iter().filter_map(|object| u16::try_from(object.instance).ok());
    let mut classes = vec![None; usize::from(numbers.max().unwrap_or(0)) + 1];
    for object in &row.objects {
        if let Some(class) = usize::try_from(object.instance).ok().and_then(|place| classes.get_mut(place)) {
            *class = u16::try_from(object.class).ok();
        }
    }
    let wrong = |(&label, &instance): (&u16, &u16)| match instance {
        0 => !ground(label),
        instance => classes.get(usize::from(instance)).copied().flatten().is_some_and(|class| class != label),
    };
    let mut count = 0;
    let mut first = None;
    for (i, pair) in label.iter().zip(instance).enumerate() {
        if wrong(pair) {
            count += 1;
            first = first.or(Some((i, *pair.0, *pair.1)));
        }
    }
    if let Some((i, label, instance)) = first {
        let cols = row.cols.max(1) as usize;
        let what = format!(
            "{count} pixels have a class that their instance has not; the first, column {} row {}, is class \
                {label} of instance {instance}",
            i % cols,
            i / cols
        );
        report.fault(Code::InstanceClass, place, what);
    }
}
