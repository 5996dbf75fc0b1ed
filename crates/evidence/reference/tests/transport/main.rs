//! Light inside matter: diffusion on voxels and along fibres, and the media that it is asked about.

mod diffusion_voxels;
mod fibres;
mod medium_faults;
