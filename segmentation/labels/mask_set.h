#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/image.h"

namespace pliant {

/// Id masks of the photos.  Id 0 = unlabelled and ignored; ids are unlimited and need not be consecutive.
struct MaskSet {
  struct View {
    int camera = -1;  ///< index into the scene's cameras
    IdImage ids;      ///< size of that camera
  };
  std::vector<View> views;
  std::map<uint32_t, std::string> names;  ///< from labels.json; ids without a name are "object_<id>"
  std::vector<std::string> warnings;

  std::vector<uint32_t> ids() const;  ///< all ids > 0 that occur, ascending
  std::string name_of(uint32_t id) const;
};

/// The ids of a camera from a picture of its shape but any size.
using FitMask = std::function<IdImage(const IdImage& ids, int camera)>;

/// Reads id pictures named like the cameras (`<camera>.png`, or the photo's name with .png behind it), also in folders
/// like those of the photos (`cam1/0001.png` of `images/cam1/0001.jpg`), else binary pictures in folders
/// (mask_layouts.h): white pictures in a single folder are those of one object.  Cameras without a mask are warned
/// about; no mask at all, an unreadable picture, one of another size or with as many ids as a photo has colours is an
/// Error{kInput}.  `labels`: JSON object id -> name, may be empty; where folders name the objects, only a file among
/// them is read.  Binary pictures also show what is no object: where a camera has one of every object, other pixels
/// become the background.  With `fit`, pictures may have any size of their camera's shape, and become what it returns
/// as soon as they are read.
MaskSet load_masks(const std::filesystem::path& folder, const std::filesystem::path& labels,
                   const std::vector<Camera>& cameras, const FitMask& fit = {});

/// Names of labels.json: a JSON object id -> name; an empty name is none.
std::map<uint32_t, std::string> read_label_names(const std::filesystem::path& file);

/// The file that names the objects of masks in `folder`: the labels.json among them, else `labels`, which may be empty.
std::filesystem::path labels_of(const std::filesystem::path& folder, const std::filesystem::path& labels);

/// An id that is not used yet: one above all others, or the lowest one where an id picture holds none above.
uint32_t free_id(const std::set<uint32_t>& used);

/// What a person should know where masks leave id 0 unlabelled; empty where that is no loss.  `classes`: names of the
/// objects that were learnt; `unlabelled`: share of what the views show without a label.
std::string warning_of_zero(const std::vector<std::string>& classes, double unlabelled);

/// Gives pixels of id 0 the id that is named "background", else one of their own, see free_id; returns it.
uint32_t label_background(MaskSet& masks);
/// The same in some of the views, by index.
uint32_t label_background(MaskSet& masks, const std::vector<size_t>& views);

}  // namespace pliant
