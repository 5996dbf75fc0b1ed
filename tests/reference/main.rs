//! Production against slow and obvious reference models, and these against published values. Takes minutes.

mod boards;
mod borders;
mod contrast;
mod defects;
mod drawn_packs;
mod expose;
mod expose_camera;
mod expose_laser;
mod expose_parts;
mod foil_through_film;
mod front_faces;
mod half_spaces;
mod kept;
mod layers;
mod monte_carlo;
mod pack;
mod rays;
mod table;
