#include "app/fit/fit_pictures.h"

#include <algorithm>
#include <cmath>

#include "app/report/chart.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

const Vec3f kBlack(0, 0, 0);

float luminance(const ImageF& picture, int x, int y) {
  return 0.3f * picture(x, y, 0) + 0.6f * picture(x, y, 1) + 0.1f * picture(x, y, 2);
}

void paste(ImageF& canvas, const ImageF& part, int left, int top) {
  for (int y = 0; y < part.height && top + y < canvas.height; ++y)
    for (int x = 0; x < part.width && left + x < canvas.width; ++x)
      for (int c = 0; c < 3; ++c) canvas(left + x, top + y, c) = part(x, y, c);
}

/// [T, length, 3] as a picture; time runs down, or to the right, stretched to at least `least` px.
ImageF slice_picture(const std::vector<float>& rows, int frames, int length, bool time_down, int least) {
  const int stretch = std::max(1, (least + frames - 1) / std::max(1, frames)), span = frames * stretch;
  ImageF out(time_down ? length : span, time_down ? span : length, 3);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const int t = (time_down ? y : x) / stretch, i = time_down ? x : y;
      for (int c = 0; c < 3; ++c) out(x, y, c) = rows[(static_cast<size_t>(t) * length + i) * 3 + c];
    }
  return out;
}

}  // namespace

ImageF picture_of_drivers(const FitScene& fit, const std::vector<double>& value, double low, double high,
                          const std::string& label) {
  const DrawnObject<float>& drawn = *fit.drawn;
  CHECK(value.size() == drawn.drivers.size() && low > 0);
  if (high < 1.02 * low) {
    const double middle = std::sqrt(low * high);
    low = middle / 1.6;
    high = middle * 1.6;
  }
  // Blended logarithm and share of Gaussians that follow drivers.
  const size_t background = drawn.background.size();
  const CloudOf<float> all = drawn.at(initial_state(fit.body.particles));
  std::vector<float> features(2 * all.size(), 0.0f);
  for (size_t g = 0; g < drawn.object.size(); ++g) {
    double sum = 0, total = 0;
    for (int k = 0; k < Binding::kCount; ++k) {
      const size_t slot = g * Binding::kCount + k;
      const int driver = drawn.binding.driver[slot];
      if (driver < 0) break;
      sum += drawn.binding.weight[slot] * std::log(value[driver]);
      total += drawn.binding.weight[slot];
    }
    if (!(total > 0)) continue;
    features[2 * (background + g)] = 1;
    features[2 * (background + g) + 1] = static_cast<float>(sum / total);
  }
  const ImageF shares = render(all, fit.video.camera, drawn.render, features, 2).features;
  const ImageF bar = draw_log_bar(low, high, label, fit.still.width);
  ImageF out(fit.still.width, fit.still.height + bar.height, 3);
  for (int y = 0; y < fit.still.height; ++y)
    for (int x = 0; x < fit.still.width; ++x) {
      const float share = std::clamp(shares(x, y, 0), 0.0f, 1.0f),
                  light = std::clamp(luminance(fit.still, x, y), 0.0f, 1.0f);
      const double at =
          share > 1e-3f ? (shares(x, y, 1) / shares(x, y, 0) - std::log(low)) / (std::log(high) - std::log(low)) : 0;
      const Vec3f color = map_color(at) * (0.75f + 0.25f * light);
      for (int c = 0; c < 3; ++c) out(x, y, c) = share * color[c] + (1 - share) * (0.35f + 0.6f * light);
    }
  paste(out, bar, 0, fit.still.height);
  return out;
}

SpaceTimeSlices::SpaceTimeSlices(const FitView& fit) : width_(fit.still.width), height_(fit.still.height) {
  const ImageF& first = fit.video.frames[0];
  std::vector<double> of_row(height_, 0.0), of_column(width_, 0.0);
  const size_t step = std::max<size_t>(1, fit.video.frames.size() / 24);
  for (size_t f = step; f < fit.video.frames.size(); f += step) {
    const ImageF& frame = fit.video.frames[f];
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        if (!(fit.moving(x, y) > 0.5f)) continue;
        double change = 0;
        for (int c = 0; c < 3; ++c) change += std::abs(frame(x, y, c) - first(x, y, c));
        of_row[y] += change;
        of_column[x] += change;
      }
  }
  row_ = static_cast<int>(std::max_element(of_row.begin(), of_row.end()) - of_row.begin());
  column_ = static_cast<int>(std::max_element(of_column.begin(), of_column.end()) - of_column.begin());
}

void SpaceTimeSlices::add(const ImageF& seen, const ImageF& drawn) {
  ++frames_;
  for (int x = 0; x < width_; ++x)
    for (int c = 0; c < 3; ++c) {
      seen_row_.push_back(seen(x, row_, c));
      drawn_row_.push_back(drawn(x, row_, c));
    }
  for (int y = 0; y < height_; ++y)
    for (int c = 0; c < 3; ++c) {
      seen_column_.push_back(seen(column_, y, c));
      drawn_column_.push_back(drawn(column_, y, c));
    }
}

ImageF SpaceTimeSlices::picture() const {
  constexpr int kGap = 8, kCaption = 22;
  const ImageF rows[] = {slice_picture(seen_row_, frames_, width_, true, 160),
                         slice_picture(drawn_row_, frames_, width_, true, 160)};
  const ImageF columns[] = {slice_picture(seen_column_, frames_, height_, false, width_),
                            slice_picture(drawn_column_, frames_, height_, false, width_)};
  const int wide = std::max(rows[0].width, columns[0].width);
  ImageF out(2 * wide + kGap, 2 * kCaption + rows[0].height + columns[0].height + kGap, 3, 1.0f);
  const char* names[] = {"video", "fit"};
  for (int side = 0; side < 2; ++side) {
    const int left = side * (wide + kGap);
    draw_text(out, std::string(names[side]) + ": row " + std::to_string(row_) + ", time down", left + 2, 16, kBlack);
    paste(out, rows[side], left, kCaption);
    const int top = kCaption + rows[side].height + kGap;
    draw_text(out, std::string(names[side]) + ": column " + std::to_string(column_) + ", time right", left + 2,
              top + 16, kBlack);
    paste(out, columns[side], left, top + kCaption);
  }
  return out;
}

}  // namespace pliant
