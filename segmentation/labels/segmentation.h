#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/image.h"
#include "gaussians/base/types.h"
#include "gaussians/render/splat.h"

namespace pliant {

constexpr int kSemanticChannels = 16;

/// The semantic attribute of every Gaussian and what follows from it (Sim Anything supplement, eq. 1).
struct Segmentation {
  std::vector<float> attribute;                 ///< y [N, 16]
  std::vector<float> classifier;                ///< [C, 16] weights, shared by all views
  std::vector<float> classifier_bias;           ///< [C]
  std::vector<uint32_t> class_id;               ///< [C] id of class c, ascending
  std::vector<std::string> class_name;          ///< [C]
  std::vector<std::vector<int>> class_cameras;  ///< [C] cameras, ascending, whose masks hold the id; empty = not known
  std::vector<std::string> class_origin;        ///< [C] how it was found, a phrase; empty = not known
  double screen_variance = splat::kScreenVariance;  ///< of the low-pass filter with which attributes are blended (px^2)
  bool antialiased = false;       ///< the scene is drawn with opacity compensation; files do not hold it
  uint32_t next_id = 0;           ///< no object ever had this id or a higher one; 0 = one above class_id
  std::vector<uint32_t> label;    ///< [N] most probable id
  std::vector<float> confidence;  ///< [N] its probability
  std::vector<uint8_t> seen;      ///< [N] 1 = some view sees it; 0 = label taken from neighbours
};

/// One row of objects.json.
struct ObjectEntry {
  uint32_t id = 0;
  std::string name;
  float score = 0;  ///< mean confidence
  Box bounds;       ///< scene units, 2nd to 98th percentile of its Gaussians
  size_t gaussians = 0;
  int views = 0;       ///< in which it was seen, see Segmentation::class_cameras
  std::string origin;  ///< how it was found
};
std::vector<ObjectEntry> list_objects(const Segmentation& segmentation, const std::vector<Vec3f>& position);

/// Class probabilities [C] of Gaussian i: softmax of the classifier applied to its attribute.
std::vector<float> class_probabilities(const Segmentation& segmentation, size_t i);

/// Index of class `id`, -1 when there is none.
int class_of_id(const Segmentation& segmentation, uint32_t id);

/// Recomputes label and confidence from attribute and classifier.
void update_labels(Segmentation& segmentation);

/// The id picture of a view: the most probable class of the blended attribute S, 0 where accumulated opacity < 0.5.
IdImage render_ids(const Segmentation& segmentation, const GaussianCloud& cloud, const Camera& camera);

/// Fills class_cameras from the id pictures of all cameras.
void find_class_cameras(const GaussianCloud& cloud, const std::vector<Camera>& cameras, Segmentation& segmentation);

/// The lowest id that no object has or had.
uint32_t unused_id(const Segmentation& segmentation);

/// Intersection over union per id that occurs in the truth, summed over all pictures; unlabelled pixels of the truth
/// are left out.
struct IdAgreement {
  std::map<uint32_t, double> iou;
  double mean = 0;  ///< mIoU, mean over ids
};
IdAgreement id_agreement(std::span<const IdImage> predicted, std::span<const IdImage> truth);

}  // namespace pliant
