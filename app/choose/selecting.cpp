#include "app/choose/selecting.h"

#include <omp.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "app/segment/prepared_scene_file.h"
#include "app/segment/segment_stage.h"
#include "gaussians/base/error.h"
#include "gaussians/render/render.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr float kClick = 8;  // px, width

/// {NAME: {camera, width, height, runs}}, the runs of 0 and 1 of a mask.
json mask_message(const char* name, int index, int width, int height, const std::vector<uint32_t>& mask) {
  return {{name, {{"camera", index}, {"width", width}, {"height", height}, {"runs", run_lengths(mask)}}}};
}

}  // namespace

Selecting::Selecting(const Context& context, const Scene& scene, const PreparedScene& prepared,
                     std::function<void(const json&)> tell, std::function<void(const Answer&)> selected)
    : context_(context),
      scene_(scene),
      prepared_(prepared),
      tell_(std::move(tell)),
      selected_(std::move(selected)),
      thread_([this] { work(); }) {}

Selecting::~Selecting() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void Selecting::ask(Marks marks, int camera) {
  {
    const std::lock_guard lock(mutex_);
    question_ = Question{std::move(marks), camera};
    hover_.reset();
  }
  wake_.notify_one();
}

void Selecting::hover(int camera, const Vec2f& pixel) {
  {
    const std::lock_guard lock(mutex_);
    hover_ = Hover{camera, pixel};
  }
  wake_.notify_one();
}

bool Selecting::waiting() {
  const std::lock_guard lock(mutex_);
  return ended_ || question_;
}

void Selecting::work() {
  if (context_.threads > 0) omp_set_num_threads(context_.threads);
  for (;;) {
    std::optional<Question> question;
    std::optional<Hover> hover;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return ended_ || question_ || hover_; });
      if (ended_) return;
      question.swap(question_);
      if (!question) hover.swap(hover_);
    }
    try {
      if (question) answer(*question);
      if (hover) answer(*hover);
    } catch (const std::exception& error) {
      if (!question) continue;  // there is nothing where the pointer is
      tell_({{"failed", error.what()}});
      selected_({question->marks, error.what()});
    }
  }
}

void Selecting::answer(const Question& question) {
  const Gesture gesture = gesture_of(segment_by(question.marks), scene_.cameras);
  const GestureOptions options = gesture_options(context_, scene_);
  const auto start = std::chrono::steady_clock::now();
  const GestureResult result =
      select_by_gesture(options, gesture, {}, scene_.cloud, scene_.cameras, prepared_, &steps_);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::vector<float> member(scene_.cloud.size());
  for (size_t p = 0; p < member.size(); ++p) member[p] = result.selected(p);
  tell_({{"selected", {{"gaussians", result.summary.selected}, {"seconds", seconds}}}});
  std::vector<int> cameras = shown_cameras(scene_);
  if (const auto first = std::find(cameras.begin(), cameras.end(), question.camera); first != cameras.end())
    std::rotate(cameras.begin(), first, cameras.end());
  for (const int index : cameras) {
    const Camera camera = shown_camera(scene_, index);
    const ImageF inside = render(scene_.cloud, camera, options.render, member, 1).features;
    std::vector<uint32_t> mask(inside.pixels());
    for (size_t i = 0; i < mask.size(); ++i) mask[i] = inside.data[i] > 0.5f;
    tell_(mask_message("mask", index, camera.width, camera.height, mask));
    if (waiting()) return;
  }
  selected_({question.marks, ""});
}

void Selecting::answer(const Hover& hover) {
  const RegionView* view = prepared_.view_of(hover.camera);
  if (!view) return;
  const StrokePrompt click{hover.camera, true, {hover.pixel}, kClick};
  const std::vector<uint8_t> member =
      guess_by_click(gesture_options(context_, scene_), click, scene_.cloud, scene_.cameras, prepared_);
  std::vector<uint8_t> shown(view->size());
  for (size_t r = 0; r < shown.size(); ++r) {
    float inside = 0;
    for (uint32_t e = view->row_start[r]; e < view->row_start[r + 1]; ++e)
      if (member[view->gaussian[e]]) inside += view->weight[e];
    shown[r] = inside > 0.5f * view->area[r];
  }
  std::vector<uint32_t> mask(view->region.size());
  for (size_t i = 0; i < mask.size(); ++i) mask[i] = shown[view->region[i]];
  tell_(mask_message("hover", hover.camera, view->window.camera.width, view->window.camera.height, mask));
}

}  // namespace pliant
