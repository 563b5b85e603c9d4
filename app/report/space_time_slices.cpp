#include "app/report/space_time_slices.h"

#include <algorithm>
#include <cmath>

#include "app/report/chart.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr int kGap = 8, kCaption = 22, kLeastTime = 160, kLeastWidth = 260;  // px; the width holds a caption
constexpr size_t kLongestName = 12;

/// [T, length, 3] as a picture; time runs down, or to the right, stretched to at least `least` px.
ImageF slice_picture(const std::vector<float>& lines, int frames, int length, bool time_down, int least) {
  const int stretch = std::max(1, (least + frames - 1) / std::max(1, frames)), span = frames * stretch;
  ImageF out(time_down ? length : span, time_down ? span : length, 3);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const int t = (time_down ? y : x) / stretch, i = time_down ? x : y;
      for (int c = 0; c < 3; ++c) out(x, y, c) = lines[(static_cast<size_t>(t) * length + i) * 3 + c];
    }
  return out;
}

double rmse_of(const std::vector<float>& a, const std::vector<float>& b) {
  double square = 0;
  for (size_t i = 0; i < a.size(); ++i) square += std::pow(double(a[i]) - double(b[i]), 2);
  return std::sqrt(square / static_cast<double>(std::max<size_t>(1, a.size())));
}

}  // namespace

SliceLines most_changed_lines(const std::vector<ImageF>& frames, const ImageF& moving) {
  CHECK(!frames.empty());
  const ImageF& first = frames[0];
  std::vector<double> of_row(first.height, 0.0), of_column(first.width, 0.0);
  const size_t step = std::max<size_t>(1, frames.size() / 24);
  for (size_t f = step; f < frames.size(); f += step)
    for (int y = 0; y < first.height; ++y)
      for (int x = 0; x < first.width; ++x) {
        if (!moving.empty() && !(moving(x, y) > 0.5f)) continue;
        double change = 0;
        for (int c = 0; c < 3; ++c) change += std::abs(frames[f](x, y, c) - first(x, y, c));
        of_row[y] += change;
        of_column[x] += change;
      }
  const auto largest = [](const std::vector<double>& sums) {
    return static_cast<int>(std::max_element(sums.begin(), sums.end()) - sums.begin());
  };
  return {largest(of_row), largest(of_column)};
}

void SpaceTimeSlices::add(std::span<const ImageF* const> pictures) {
  CHECK(pictures.size() == clips_.size());
  width_ = pictures[0]->width;
  height_ = pictures[0]->height;
  for (size_t k = 0; k < clips_.size(); ++k) {
    const ImageF& picture = *pictures[k];
    CHECK(picture.width == width_ && picture.height == height_ && lines_.row < height_ && lines_.column < width_);
    for (int x = 0; x < width_; ++x)
      for (int c = 0; c < 3; ++c) clips_[k].row.push_back(picture(x, lines_.row, c));
    for (int y = 0; y < height_; ++y)
      for (int c = 0; c < 3; ++c) clips_[k].column.push_back(picture(lines_.column, y, c));
  }
  ++frames_;
}

ImageF SpaceTimeSlices::picture() const {
  CHECK(frames_ > 0);
  std::vector<ImageF> rows, columns;
  int wide = kLeastWidth;
  for (const Lines& lines : clips_) {
    rows.push_back(slice_picture(lines.row, frames_, width_, true, kLeastTime));
    columns.push_back(slice_picture(lines.column, frames_, height_, false, width_));
    wide = std::max({wide, rows.back().width, columns.back().width});
  }
  const int count = static_cast<int>(clips_.size()), top = kCaption + rows[0].height + kGap;
  ImageF out(count * wide + (count - 1) * kGap, top + kCaption + columns[0].height, 3, 1.0f);
  const Vec3f black(0, 0, 0);
  for (int k = 0; k < count; ++k) {
    const int left = k * (wide + kGap);
    const std::string name = names_[k].substr(0, kLongestName);
    draw_text(out, name + ": row " + std::to_string(lines_.row) + ", time down", left + 2, 16, black);
    paste(out, rows[k], left, kCaption);
    draw_text(out, name + ": column " + std::to_string(lines_.column) + ", time right", left + 2, top + 16, black);
    paste(out, columns[k], left, top + kCaption);
  }
  return out;
}

std::pair<double, double> SpaceTimeSlices::rmse(size_t clip) const {
  return {rmse_of(clips_[clip].row, clips_[0].row), rmse_of(clips_[clip].column, clips_[0].column)};
}

}  // namespace pliant
