#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/run/run_directory.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// How far the names of objects in the scene file hold for the objects of a run.
struct FileNames {
  enum class Reach {
    kGiven,    ///< selected or found automatically: only for what a person has called so
    kOther,    ///< other masks than the file's
    kAll,      ///< masks or a classifier for a file without masks
    kTrained,  ///< the masks of a joint training, which have the file's object
    kOwn       ///< the file's masks, which have all that it names
  };
  Reach reach = Reach::kGiven;
  bool ids = false;  ///< IDs and default names ("object_3") hold as well; else they may mean something else here
};

/// By the record of `segment`, whose summary is `segmented`, and of the training of the scene.
FileNames names_of_file(const RunDirectory& run, const Scene& scene, const nlohmann::json& segmented);

/// What an object that the scene file calls `name` is called after a person's edits (the note "edits"), which may be
/// the ID of the object that it was merged into; empty where the file cannot mean any of these objects.
std::string present_name(const FileNames& names, const nlohmann::json& edits, std::string name);

}  // namespace pliant
