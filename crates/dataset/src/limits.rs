//! Limits of the simulation: what the scans of a subject lack beside real ones, for the dataset card and for
//! Croissant's `dataLimitations`.

use output_schema::DatasetHead;

use super::recipe_words::has_speckle;

/// What is true of every subject.
const LIMITS_OF_ALL: [&str; 6] = [
    "The scans are simulated: no camera saw the objects, and optical coefficients are the recipe's, whose defaults \
        are estimates from publications.",
    "Numbers that the recipe draws follow its distributions, which need not be those of your line.",
    "Wear of the instrument and dust in the air are absent; so is everything that the recipe does not name.",
    "Light has no polarisation, and goes from the object onto the conveyor and back in no scan.",
    "Range is what a camera measures: of matter that lets light in it lies below the true height, by up to some \
        tenths of a mm on wood and plastic, and not at all on metal.",
    "A column sees one point, or two where an edge cuts it.",
];

const LIMITS_OF_SPECKLE: [&str; 1] = ["The patterns of speckle repeat after 64 sensor rows."];

const LIMITS_OF_WOOD: [&str; 2] = [
    "What rays, canals and vessels are below the face counts in the mean alone; light between the walls of a crack is \
        thrown back once.",
    "Boards shade and hide themselves at openings and marks, not at single fibres.",
];

const LIMITS_OF_PACKS: [&str; 1] =
    ["Packs have no two-part capsule shells, peeled or mottled coats, bent fibres, slits of a perforation or print."];

/// Of packs, by the model of transport that is the default.
const LIMITS_OF_PACKS_BY_KERNEL: [&str; 1] = [
    "The model of light takes film, air and what lies below as parallel, and of a pocket's walls only that they hold \
        light together; mirror images bounce once, and not off tablets and foil.",
];

const LIMITS_OF_PIECES: [&str; 1] =
    ["The piece is of one material, without texture, scratches, burrs or dirt; its labels tell the piece from the \
        background alone."];

/// The limits of a dataset's subject, bench and model of light, each a sentence or two.
pub(super) fn limits(head: &DatasetHead) -> Vec<&'static str> {
    let own: &[&str] = match head.subject.as_str() {
        "wood" => &LIMITS_OF_WOOD,
        "blister" => &LIMITS_OF_PACKS,
        _ => &LIMITS_OF_PIECES,
    };
    let speckle: &[&str] = if has_speckle(head) { &LIMITS_OF_SPECKLE } else { &[] };
    let by_kernel = head.subject == "blister" && head.recipe.canonical["transport"]["model"] == "kernel";
    let light: &[&str] = if by_kernel { &LIMITS_OF_PACKS_BY_KERNEL } else { &[] };
    LIMITS_OF_ALL.iter().chain(speckle).chain(own).chain(light).copied().collect()
}
