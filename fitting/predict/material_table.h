#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "physics/laws/material.h"

namespace pliant {

struct Band {
  double low = 0, typical = 0, high = 0;
};

/// Where a row comes from: a test that somebody made, a published or tabulated value, our own judgement.
enum class RowKind { kMeasured, kHandbook, kEstimate };
const char* row_kind_name(RowKind kind);

/// A row of materials.csv.
struct KnownMaterial {
  std::string name;
  std::vector<std::string> synonyms;
  std::string group;             ///< column `class`
  Band young, poisson, density;  ///< Pa, 1, kg/m^3
  Material law;                  ///< with the constants that it needs
  RowKind kind = RowKind::kEstimate;
  bool young_of_source = false, poisson_of_source = false, density_of_source = false;  ///< the others are estimates
  std::string source, licence;  ///< of rows that are no estimates
  std::string reason;           ///< of what is estimated
};

struct KnownPart {
  size_t material = 0;       ///< row of MaterialTable::materials
  double share = 0;          ///< of the object's volume
  bool moves = false;        ///< what a person sees move: the plant, not the pot
  bool replaceable = false;  ///< by a material in the label that things are built of: a steel chair
  bool shows = false;        ///< a figure, which is made of anything: a chocolate statue; then replaceable, too
};

/// A row of objects.csv.
struct KnownObject {
  std::string name;
  std::vector<std::string> synonyms;
  std::vector<KnownPart> parts;  ///< one of them moves at least; their shares add up to 1
  Band height;                   ///< m, the usual one
  bool longest = false;          ///< `height` is that of its longest extent, whichever way it lies
  Band frequency;                ///< Hz, the first at which such a thing visibly sways; 0 = rigid
  double bulk_density = 0;       ///< kg/m^3 of a hollow thing with what its walls enclose; 0 = that of its materials
};

struct MaterialTable {
  std::vector<KnownMaterial> materials;
  std::vector<KnownObject> objects;
  std::map<std::string, size_t> material_of, object_of;  ///< row by label_key of names and synonyms
  size_t longest_name = 0;                               ///< words
};

/// Reads the two tables: cells parted by commas, without quotes; lists in a cell parted by semicolons; parts as
/// material:share, with * for what moves, = for what a label's material replaces and == for what is made of anything;
/// size is empty or "longest"; bulk_density may be empty.  Throws Error{kInput} naming file, line, column and value.
MaterialTable parse_material_table(std::string_view materials, const std::string& materials_file,
                                   std::string_view objects, const std::string& objects_file);

/// The tables that the program ships with.
const MaterialTable& material_table();
std::string_view materials_csv();
std::string_view objects_csv();

/// The row of that name or synonym.  Throws Error{kUsage} that lists near names.
const KnownMaterial& find_material(const MaterialTable& table, const std::string& name);

/// Every material with its numbers, split by kind, and the names of the objects; for people.
std::string material_list(const MaterialTable& table);

}  // namespace pliant
