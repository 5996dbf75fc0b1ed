//! Range as EXR files of everything have it, where a dataset keeps numbers in tables and what they leave in EXR files:
//! rules know one Range.

use output_schema::channel::CHANNELS;
use output_schema::{Channel, DatasetHead};

use super::sample_to_check::SampleToCheck;
use crate::{ExrChannel, RANGE_REST, range_joined};

/// The declaration of Range in its place.
fn whole() -> Option<Channel> {
    CHANNELS.into_iter().find(|channel| channel.name == "Range")
}

/// The channels of EXR files as rules see them.
pub(super) fn shown_channels(head: &DatasetHead) -> Vec<Channel> {
    let shown = |channel: Channel| if channel.name == RANGE_REST { whole().unwrap_or(channel) } else { channel };
    head.channels().into_iter().map(shown).collect()
}

/// The channels of a file with Range out of the row's numbers and what these leave; without either where the row's
/// image cannot be read, which another rule tells.
///
/// # Errors
/// Where image and channel do not have one size.
pub(super) fn joined(channels: Vec<ExrChannel>, sample: &SampleToCheck) -> Result<Vec<ExrChannel>, String> {
    let (row, numbers) = (&sample.row, sample.images.get("range"));
    let shown = |channel: ExrChannel| match (channel.name.as_str(), numbers, whole()) {
        (RANGE_REST, Some(numbers), Some(range)) => {
            let joined = range_joined(numbers, &channel.numbers, sample.cols(), row.range_offset, row.range_scale);
            Some(joined.map(|numbers| ExrChannel { name: range.name.into(), samples: range.samples, numbers }))
        }
        (RANGE_REST, ..) => None,
        _ => Some(Ok(channel)),
    };
    channels.into_iter().filter_map(shown).collect()
}
