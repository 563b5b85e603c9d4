#include "app/report/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr std::array<std::array<int, 3>, 6> kPalette = {
    {{31, 96, 180}, {214, 84, 26}, {36, 140, 72}, {140, 70, 170}, {170, 130, 20}, {90, 90, 90}}};

cv::Scalar rgb(const std::array<int, 3>& c) { return {double(c[0]), double(c[1]), double(c[2])}; }

const cv::Scalar kInk(40, 40, 40), kGrid(225, 225, 225), kFrame(120, 120, 120), kMark(150, 150, 150);

void write(cv::Mat& canvas, const std::string& text, cv::Point at, const cv::Scalar& color, double size) {
  cv::putText(canvas, text, at, cv::FONT_HERSHEY_SIMPLEX, size / 22, color, 1, cv::LINE_AA);
}

int text_width(const std::string& text, double size) {
  int below = 0;
  return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size / 22, 1, &below).width;
}

ImageF to_image(const cv::Mat& canvas) {
  ImageF out(canvas.cols, canvas.rows, 3);
  for (int y = 0; y < canvas.rows; ++y)
    for (int x = 0; x < canvas.cols; ++x)
      for (int c = 0; c < 3; ++c) out(x, y, c) = canvas.at<cv::Vec3b>(y, x)[c] / 255.0f;
  return out;
}

/// An axis with about `wanted` round steps.
struct Axis {
  double low = INFINITY, high = -INFINITY, step = 1;

  void add(double value) {
    if (std::isfinite(value)) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  void settle(int wanted, double margin) {
    if (!(low <= high)) {
      low = 0;
      high = 1;
    }
    if (high - low <= 1e-12 * std::max(std::abs(low), std::abs(high))) {
      const double spread = high == 0 ? 1 : 0.1 * std::abs(high);
      low -= spread;
      high += spread;
    }
    const double width = high - low;
    low -= margin * width;
    high += margin * width;
    const double rough = (high - low) / wanted, power = std::pow(10, std::floor(std::log10(rough)));
    step = power * (rough / power < 1.5 ? 1 : rough / power < 3.5 ? 2 : rough / power < 7.5 ? 5 : 10);
  }
  double share(double value) const { return (value - low) / (high - low); }
};

std::string tick_label(double value, double step) {
  return fmt::format("{:.4g}", std::abs(value) < 1e-9 * step ? 0.0 : value);
}

}  // namespace

ImageF draw_chart(const Chart& chart) {
  constexpr int kLeft = 74, kRight = 18, kTop = 34, kBottom = 50;
  cv::Mat canvas(chart.height, chart.width, CV_8UC3, cv::Scalar(255, 255, 255));
  Axis across, up;
  for (const Curve& curve : chart.curves) {
    CHECK(curve.x.size() == curve.y.size());
    for (size_t i = 0; i < curve.x.size(); ++i)
      if (std::isfinite(curve.y[i])) {
        across.add(curve.x[i]);
        up.add(curve.y[i]);
      }
  }
  if (chart.from_zero) up.add(0);
  across.settle(8, 0);
  up.settle(6, 0.06);
  const int width = chart.width - kLeft - kRight, height = chart.height - kTop - kBottom;
  const auto place = [&](double x, double y) {
    const double v = std::clamp(up.share(y), -1.0, 2.0);
    return cv::Point(kLeft + static_cast<int>(std::lround(across.share(x) * width)),
                     kTop + static_cast<int>(std::lround((1 - v) * height)));
  };
  for (double x = std::ceil(across.low / across.step) * across.step; x <= across.high + 1e-9 * across.step;
       x += across.step) {
    const int at = place(x, up.low).x;
    cv::line(canvas, {at, kTop}, {at, kTop + height}, kGrid);
    const std::string label = tick_label(x, across.step);
    write(canvas, label, {at - text_width(label, 10) / 2, kTop + height + 16}, kInk, 10);
  }
  for (double y = std::ceil(up.low / up.step) * up.step; y <= up.high + 1e-9 * up.step; y += up.step) {
    const int at = place(across.low, y).y;
    cv::line(canvas, {kLeft, at}, {kLeft + width, at}, kGrid);
    const std::string label = tick_label(y, up.step);
    write(canvas, label, {kLeft - 6 - text_width(label, 10), at + 4}, kInk, 10);
  }
  for (const double x : chart.marks) {
    const int at = place(x, up.low).x;
    for (int y = kTop; y < kTop + height; y += 8)
      cv::line(canvas, {at, y}, {at, std::min(y + 4, kTop + height)}, kMark);
  }
  for (size_t k = 0; k < chart.curves.size(); ++k) {
    const Curve& curve = chart.curves[k];
    const cv::Scalar color = rgb(kPalette[(curve.color < 0 ? k : curve.color) % kPalette.size()]);
    for (size_t i = 0; i < curve.x.size(); ++i) {
      if (!std::isfinite(curve.y[i])) continue;
      if (curve.dots)
        cv::circle(canvas, place(curve.x[i], curve.y[i]), 3, color, cv::FILLED, cv::LINE_AA);
      else if (i > 0 && std::isfinite(curve.y[i - 1]))
        cv::line(canvas, place(curve.x[i - 1], curve.y[i - 1]), place(curve.x[i], curve.y[i]), color, 2, cv::LINE_AA);
    }
  }
  cv::rectangle(canvas, {kLeft, kTop}, {kLeft + width, kTop + height}, kFrame);
  write(canvas, chart.title, {kLeft, 20}, kInk, 12);
  write(canvas, chart.x_label, {kLeft + (width - text_width(chart.x_label, 11)) / 2, chart.height - 12}, kInk, 11);
  // The label of the upward axis, turned.
  cv::Mat label(20, std::max(1, height), CV_8UC3, cv::Scalar(255, 255, 255)), turned;
  write(label, chart.y_label, {std::max(0, (height - text_width(chart.y_label, 11)) / 2), 14}, kInk, 11);
  cv::rotate(label, turned, cv::ROTATE_90_COUNTERCLOCKWISE);
  turned.copyTo(canvas(cv::Rect(2, kTop, turned.cols, turned.rows)));
  // Names stand in the upper right corner.
  int line = kTop + 16;
  for (size_t k = 0; k < chart.curves.size(); ++k) {
    if (chart.curves[k].name.empty()) continue;
    const int at = kLeft + width - 8 - text_width(chart.curves[k].name, 10);
    const cv::Scalar color = rgb(kPalette[(chart.curves[k].color < 0 ? k : chart.curves[k].color) % kPalette.size()]);
    cv::rectangle(canvas, {at - 28, line - 12}, {kLeft + width - 2, line + 4}, cv::Scalar(255, 255, 255), cv::FILLED);
    if (chart.curves[k].dots)
      cv::circle(canvas, {at - 14, line - 4}, 3, color, cv::FILLED, cv::LINE_AA);
    else
      cv::line(canvas, {at - 24, line - 4}, {at - 6, line - 4}, color, 2, cv::LINE_AA);
    write(canvas, chart.curves[k].name, {at, line}, kInk, 10);
    line += 16;
  }
  return to_image(canvas);
}

Vec3f map_color(double t) {
  static const Vec3f kStops[] = {{0.05f, 0.03f, 0.30f}, {0.29f, 0.08f, 0.53f}, {0.58f, 0.15f, 0.50f},
                                 {0.85f, 0.31f, 0.36f}, {0.98f, 0.58f, 0.20f}, {0.96f, 0.95f, 0.40f}};
  const double at = 5 * std::clamp(std::isfinite(t) ? t : 0.0, 0.0, 1.0);
  const int i = std::min(4, static_cast<int>(at));
  return kStops[i] + static_cast<float>(at - i) * (kStops[i + 1] - kStops[i]);
}

ImageF draw_log_bar(double low, double high, const std::string& label, int width) {
  constexpr int kHeight = 60, kMargin = 40, kBar = 16;
  cv::Mat canvas(kHeight, width, CV_8UC3, cv::Scalar(255, 255, 255));
  const double from = std::log10(low), to = std::log10(high);
  const int length = std::max(1, width - 2 * kMargin);
  for (int x = 0; x < length; ++x) {
    const Vec3f c = 255 * map_color(x / std::max(1.0, length - 1.0));
    cv::line(canvas, {kMargin + x, 4}, {kMargin + x, 4 + kBar}, {c.x(), c.y(), c.z()});
  }
  // 1, 2 and 5 of every decade, without those that would overlap.
  int free_from = 0;
  for (int decade = static_cast<int>(std::floor(from)) - 1; decade <= std::ceil(to); ++decade)
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double value = digit * std::pow(10.0, decade),
                   share = to > from ? (std::log10(value) - from) / (to - from) : 0.5;
      if (share < -1e-9 || share > 1 + 1e-9) continue;
      const int at = kMargin + static_cast<int>(std::lround(share * (length - 1)));
      const std::string text = fmt::format("{:g}", value);
      const int half = text_width(text, 10) / 2;
      if (at - half < free_from) continue;
      cv::line(canvas, {at, 4 + kBar}, {at, 8 + kBar}, kInk);
      write(canvas, text, {at - half, 20 + kBar}, kInk, 10);
      free_from = at + half + 8;
    }
  const double size = std::min(11.0, 11.0 * (width - 4) / std::max(1, text_width(label, 11)));
  write(canvas, label, {std::max(0, (width - text_width(label, size)) / 2), kHeight - 8}, kInk, size);
  return to_image(canvas);
}

void paste(ImageF& canvas, const ImageF& part, int left, int top) {
  for (int y = 0; y < part.height && top + y < canvas.height; ++y)
    for (int x = 0; x < part.width && left + x < canvas.width; ++x)
      for (int c = 0; c < 3; ++c) canvas(left + x, top + y, c) = part(x, y, c);
}

void draw_text(ImageF& picture, const std::string& text, int x, int baseline, const Vec3f& color, double size) {
  const int w = text_width(text, size) + 2, h = static_cast<int>(1.6 * size);
  cv::Mat stamp(h, w, CV_8UC3, cv::Scalar(0, 0, 0));
  write(stamp, text, {1, static_cast<int>(1.2 * size)}, {255, 255, 255}, size);
  for (int v = 0; v < h; ++v)
    for (int u = 0; u < w; ++u) {
      const int px = x + u, py = baseline - static_cast<int>(1.2 * size) + v;
      if (px < 0 || py < 0 || px >= picture.width || py >= picture.height) continue;
      const float a = stamp.at<cv::Vec3b>(v, u)[0] / 255.0f;
      for (int c = 0; c < 3; ++c) picture(px, py, c) += a * (color[c] - picture(px, py, c));
    }
}

}  // namespace pliant
