#include "fitting/predict/material_table.h"
#include "gaussians/base/embed.h"

// PLIANT_MATERIALS and PLIANT_OBJECTS are the paths of the tables.
PLIANT_EMBED(pliant_materials_csv, PLIANT_MATERIALS);
PLIANT_EMBED(pliant_objects_csv, PLIANT_OBJECTS);

namespace pliant {

std::string_view materials_csv() {
  return {pliant_materials_csv_begin, static_cast<size_t>(pliant_materials_csv_end - pliant_materials_csv_begin)};
}
std::string_view objects_csv() {
  return {pliant_objects_csv_begin, static_cast<size_t>(pliant_objects_csv_end - pliant_objects_csv_begin)};
}

}  // namespace pliant
