#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/store/material.h"

namespace pliant {

/// Files of material fields that other programs read and write: an .npz of VoMP (one structured array `voxel_data` with
/// x, y, z, youngs_modulus, poissons_ratio, density; Pa, kg/m^3; the object in the unit cube around 0), and a .ply
/// with the vertex properties x, y, z, density, E, nu, as Pixie writes.
bool is_material_field(const std::filesystem::path& file);

/// Such a file, with positions as they stand there and without volumes.  Throws Error{kInput} naming file and field.
MaterialFile read_material_field(const std::filesystem::path& file);

/// Its positions in the scene, where they are none of the scene already: scaled alike in all directions and moved, so
/// that their box is that of the `object` samples.  Throws Error{kInput} where the boxes differ in shape.
std::vector<Vec3f> placed_in(const std::filesystem::path& file, const std::vector<Vec3f>& positions,
                             const std::vector<Vec3f>& object);

/// Throws Error{kInput} naming `field` unless the box of its positions, scene units, is that of the `object` samples
/// within a quarter of their largest extent.
void check_place(const std::filesystem::path& file, const std::string& field, const std::vector<Vec3f>& positions,
                 const std::vector<Vec3f>& object);

/// Writes a field whose positions are those of the scene: .npz (in the unit cube) or .ply (as they are).  Atomic.
/// Throws Error{kUsage} for another extension.
void write_material_field(const std::filesystem::path& file, const MaterialFile& material);

}  // namespace pliant
