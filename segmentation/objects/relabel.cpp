#include "segmentation/objects/relabel.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/random.h"
#include "segmentation/labels/spread.h"

namespace pliant {
namespace {

constexpr int kY = kSemanticChannels;
constexpr uint32_t kNobody = UINT32_MAX;  // no class's id
constexpr float kOrthogonal = 1e-3f;      // coherence below which a direction changes no logit
using Attribute = Eigen::Matrix<float, kY, 1>;
using AttributeMap = Eigen::Map<Attribute>;
using ConstAttributeMap = Eigen::Map<const Attribute>;

AttributeMap attribute_of(Segmentation& s, size_t p) { return AttributeMap(s.attribute.data() + p * kY); }
ConstAttributeMap row_of(const Segmentation& s, size_t c) { return ConstAttributeMap(s.classifier.data() + c * kY); }

/// Mean attribute [C] of the Gaussians of every class; a class is a convex region of attributes, so its mean is in it.
/// A class without Gaussians gets its row of the classifier, scaled to a typical attribute.
std::vector<Attribute> class_means(const Segmentation& s, std::span<const uint32_t> label) {
  std::vector<Eigen::Matrix<double, kY, 1>> sum(s.class_id.size(), Eigen::Matrix<double, kY, 1>::Zero());
  std::vector<size_t> count(s.class_id.size(), 0);
  double length = 0;
  for (size_t p = 0; p < label.size(); ++p) {
    const ConstAttributeMap y(s.attribute.data() + p * kY);
    length += y.norm();
    if (const int c = class_of_id(s, label[p]); c >= 0) {
      sum[c] += y.cast<double>();
      ++count[c];
    }
  }
  std::vector<Attribute> mean(s.class_id.size());
  for (size_t c = 0; c < mean.size(); ++c) {
    if (count[c] > 0)
      mean[c] = (sum[c] / static_cast<double>(count[c])).cast<float>();
    else
      mean[c] = row_of(s, c).normalized() * static_cast<float>(length / std::max<size_t>(1, label.size()));
  }
  return mean;
}

/// Mirrors y in the plane midway between a and b.
void mirror(const Attribute& a, const Attribute& b, AttributeMap y) {
  const Attribute across = b - a;
  const float length = across.norm();
  if (!(length > 0)) return;
  const Attribute u = across / length;
  y -= 2 * u.dot(y - 0.5f * (a + b)) * u;
}

void erase_class(size_t c, Segmentation& s) {
  const auto at = static_cast<std::ptrdiff_t>(c);
  s.classifier.erase(s.classifier.begin() + at * kY, s.classifier.begin() + (at + 1) * kY);
  s.classifier_bias.erase(s.classifier_bias.begin() + at);
  s.class_id.erase(s.class_id.begin() + at);
  s.class_name.erase(s.class_name.begin() + at);
  if (!s.class_cameras.empty()) s.class_cameras.erase(s.class_cameras.begin() + at);
  if (!s.class_origin.empty()) s.class_origin.erase(s.class_origin.begin() + at);
}

/// A unit direction, and its largest coherence with the rows of the classifier, by absolute value, which is small.
struct FreeDirection {
  Attribute along;
  float coherence = 0;
};

FreeDirection free_direction(const Segmentation& s, uint64_t seed) {
  const Eigen::Index classes = static_cast<Eigen::Index>(s.class_id.size());
  Eigen::MatrixXf rows(classes, kY);
  for (Eigen::Index c = 0; c < classes; ++c) rows.row(c) = row_of(s, static_cast<size_t>(c)).normalized();
  const Eigen::MatrixXd products = (rows.transpose() * rows).cast<double>();
  FreeDirection best;
  best.along = symmetric_eigen(products).vectors.col(0).cast<float>();  // least used by the rows; orthogonal to all
                                                                        // where its eigenvalue is 0
  best.coherence = (rows * best.along).cwiseAbs().maxCoeff();
  Random random(seed, s.class_id.back(), 0);
  for (int candidate = 0; candidate < 2000 && best.coherence > kOrthogonal; ++candidate) {
    Attribute u;
    for (int k = 0; k < kY; ++k) u[k] = static_cast<float>(random.normal());
    u.normalize();
    if (const float coherence = (rows * u).cwiseAbs().maxCoeff(); coherence < best.coherence) best = {u, coherence};
  }
  return best;
}

}  // namespace

void enforce_labels(std::span<const uint32_t> wanted, Segmentation& s) {
  CHECK(wanted.size() * kY == s.attribute.size());
  const int classes = static_cast<int>(s.class_id.size());
  const auto lead = [&](const Attribute& y, int label, int c) {
    return s.classifier_bias[label] - s.classifier_bias[c] + y.dot(row_of(s, label) - row_of(s, c));
  };
  const auto decoded = [&](const Attribute& y, int label) {
    for (int c = 0; c < classes; ++c)
      if (c != label && !(lead(y, label, c) > 1e-4f)) return false;
    return true;
  };
  std::vector<uint32_t> agreed(wanted.begin(), wanted.end());
  std::vector<uint8_t> agrees(wanted.size());
  const auto count = static_cast<std::ptrdiff_t>(wanted.size());
  parallel_for(
      count, [&](std::ptrdiff_t p) { agrees[p] = decoded(attribute_of(s, p), class_of_id(s, wanted[p])); }, 256);
  for (size_t p = 0; p < agreed.size(); ++p)
    if (!agrees[p]) agreed[p] = kNobody;
  const std::vector<Attribute> mean = class_means(s, agreed);
  parallel_for(
      count,
      [&](std::ptrdiff_t p) {
        if (agrees[p]) return;
        constexpr float kLead = 0.2f;
        const int label = class_of_id(s, wanted[p]);
        AttributeMap y = attribute_of(s, p);
        // The lead over every class is linear along the way to the mean, or to a stronger one of the same direction.
        for (float stretch = 1; stretch <= 8; stretch *= 2) {
          const Attribute target = stretch * mean[label];
          if (!decoded(target, label)) continue;
          float way = 0;
          for (int c = 0; c < classes; ++c) {
            if (c == label) continue;
            const float now = lead(y, label, c), there = lead(target, label, c);
            if (now < kLead) way = std::max(way, there > kLead ? (kLead - now) / (there - now) : 1.0f);
          }
          y += way * (target - y);
          break;
        }
        agrees[p] = decoded(y, label);
      },
      256);
  if (const auto failed = std::count(agrees.begin(), agrees.end(), 0); failed > 0)
    throw numerical_error("segmentation",
                          "the classifier of " + std::to_string(classes) + " classes cannot express the labels of " +
                              std::to_string(failed) + " Gaussians",
                          "merge or drop objects, or segment the scene again");
  update_labels(s);
}

void merge_classes(uint32_t to, uint32_t from, Segmentation& s) {
  const int a = class_of_id(s, from), b = class_of_id(s, to);
  CHECK(a >= 0 && b >= 0 && a != b);
  s.next_id = unused_id(s);
  const std::vector<Attribute> mean = class_means(s, s.label);
  std::vector<uint32_t> wanted = s.label;
  for (size_t p = 0; p < wanted.size(); ++p) {
    if (wanted[p] != from) continue;
    wanted[p] = to;
    mirror(mean[a], mean[b], attribute_of(s, p));
  }
  if (!s.class_cameras.empty()) {
    std::vector<int> both;
    std::set_union(s.class_cameras[a].begin(), s.class_cameras[a].end(), s.class_cameras[b].begin(),
                   s.class_cameras[b].end(), std::back_inserter(both));
    s.class_cameras[b] = std::move(both);
  }
  erase_class(static_cast<size_t>(a), s);
  enforce_labels(wanted, s);
}

void split_class(uint32_t from, uint32_t id, const std::string& name, std::span<const uint8_t> part, Segmentation& s) {
  constexpr float kLead = 6, kLength = 8;  // in the logits; of the difference of the two rows
  const int a = class_of_id(s, from);
  CHECK(a >= 0 && part.size() == s.label.size() && id >= unused_id(s));
  const Attribute mean = class_means(s, s.label)[a];
  const auto [direction, coherence] = free_direction(s, 1);
  const bool room = coherence <= kOrthogonal;
  Attribute row;
  if (room) {
    // Half of the class's probability each where an attribute has nothing along the direction, as all others have.
    row = row_of(s, a) + 0.5f * kLength * direction;
    AttributeMap(s.classifier.data() + a * kY) -= 0.5f * kLength * direction;
    s.classifier_bias[a] -= std::log(2.0f);
  } else {
    float length = 0;
    for (size_t c = 0; c < s.class_id.size(); ++c) length = std::max(length, row_of(s, c).norm());
    row = length * direction;
  }
  s.classifier.insert(s.classifier.end(), row.data(), row.data() + kY);
  s.classifier_bias.push_back(s.classifier_bias[a]);
  s.class_id.push_back(id);
  s.class_name.push_back(name);
  if (!s.class_cameras.empty()) s.class_cameras.push_back(s.class_cameras[a]);
  if (!s.class_origin.empty()) s.class_origin.push_back("");
  s.next_id = id + 1;
  std::vector<uint32_t> wanted = s.label;
  for (size_t p = 0; p < wanted.size(); ++p) {
    CHECK(!part[p] || wanted[p] == from);
    AttributeMap y = attribute_of(s, p);
    if (room) {
      const float along = wanted[p] != from ? 0 : part[p] ? kLead / kLength : -kLead / kLength;
      y += (along - direction.dot(y)) * direction;
    } else if (part[p]) {
      mirror(mean, mean.norm() * direction, y);
    }
    if (part[p]) wanted[p] = id;
  }
  enforce_labels(wanted, s);
}

size_t drop_class(uint32_t id, const std::vector<Vec3f>& position, Segmentation& s) {
  const int a = class_of_id(s, id);
  CHECK(a >= 0 && position.size() == s.label.size());
  s.next_id = unused_id(s);
  std::vector<uint8_t> kept(s.label.size());
  for (size_t p = 0; p < kept.size(); ++p) kept[p] = s.label[p] != id;
  const size_t dropped = static_cast<size_t>(std::count(kept.begin(), kept.end(), 0));
  std::vector<uint32_t> wanted = s.label;
  if (dropped == kept.size()) {
    s.class_id = {0};
    s.class_name = {"unlabelled"};
    s.classifier.assign(kY, 0.0f);
    s.classifier_bias.assign(1, 0.0f);
    s.attribute.assign(s.attribute.size(), 0.0f);
    if (!s.class_cameras.empty()) s.class_cameras = {{}};
    if (!s.class_origin.empty()) s.class_origin = {"every object was dropped"};
    std::fill(wanted.begin(), wanted.end(), 0u);
  } else {
    const std::vector<int> source = nearest_seen(position, kept);
    copy_attributes(source, s.attribute);
    for (size_t p = 0; p < wanted.size(); ++p) wanted[p] = s.label[source[p]];
    erase_class(static_cast<size_t>(a), s);
  }
  enforce_labels(wanted, s);
  return dropped;
}

}  // namespace pliant
