//! What camera, laser and sensor make of known bodies, and what is read from it, against closed forms.

mod bands;
mod blister_presence;
mod blooming;
mod camera_motion;
mod camera_optics;
mod defect_maps;
mod effects;
mod field_edges;
mod flat_target;
mod interpolated_rows;
mod laser_keys;
mod laser_light;
mod laser_places;
mod mixed_pixels;
mod object_keys;
mod pack_optics;
mod range_forms;
mod real_frames;
mod rows_left_out;
mod scatter_ratios;
mod sensor_chain;
mod sliced_wood;
mod solid_pieces;
mod speckle;
mod turntable;
mod wood_texture;
