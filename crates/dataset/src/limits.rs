//! Limits of the simulation: what the scans of a subject lack beside real ones, for the dataset card and for Croissant's `dataLimitations`.

use output_schema::DatasetHead;

/// What is true of every subject.
const LIMITS_OF_ALL: [&str; 6] = [
    "The scans are simulated: no real object was measured, and optical coefficients are estimates from publications.",
    "Numbers that the recipe draws follow its distributions, which need not be those of your line.",
    "Dust, wear and drift of the instrument and vibration but for errors of the encoder are absent; so is everything that the recipe does not name.",
    "Light has no polarisation, and goes from the object onto the conveyor and back in no scan.",
    "Range is what a camera measures: of matter that lets light in it lies below the true height, by up to some tenths of a mm on wood and plastic, and not at all on metal.",
    "A column sees one point, or two where an edge cuts it. The patterns of speckle repeat after 64 sensor rows.",
];

const LIMITS_OF_WOOD: [&str; 2] = [
    "What rays, canals and vessels are below the face counts in the mean alone; light between the walls of a crack is thrown back once.",
    "Boards shade and hide themselves at openings and marks, not at single fibres.",
];

const LIMITS_OF_PACKS: [&str; 2] = [
    "Packs have no two-part capsule shells, peeled or mottled coats, bent fibres, slits of a perforation or print.",
    "The default model of light takes film, air and what lies below as parallel, and of a pocket's walls only that they hold light together; mirror images bounce once, and not off tablets and foil.",
];

const LIMITS_OF_PIECES: [&str; 1] = [
    "The piece is of one material, without texture, scratches, burrs or dirt; its labels tell the piece from the background alone.",
];

/// The limits of a dataset's subject, each a sentence or two.
pub(super) fn limits(head: &DatasetHead) -> Vec<&'static str> {
    let own: &[&str] = match head.subject.as_str() {
        "wood" => &LIMITS_OF_WOOD,
        "blister" => &LIMITS_OF_PACKS,
        _ => &LIMITS_OF_PIECES,
    };
    LIMITS_OF_ALL.into_iter().chain(own.iter().copied()).collect()
}
