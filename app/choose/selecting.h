#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <thread>

#include "app/choose/choose_page.h"
#include "app/run/progress.h"
#include "segmentation/select/gesture.h"

namespace pliant {

/// Answers marks at the speed of a hand, in a thread of its own: what they select, by the code of `pliant segment`.
/// Nothing is written.  Messages: {"selected": {"gaussians", "seconds"}}, then per camera of the page {"mask":
/// {"camera", "width", "height", "runs"}} with run lengths of 0 and 1; {"hover": the same} where a click is guessed at;
/// {"failed": text}.
class Selecting {
 public:
  struct Answer {
    Marks marks;
    std::string failed;  ///< why they select nothing; empty = they do
  };

  /// `tell` sends a message to all clients, `selected` is told of every answer; both are called from the thread.
  /// Everything must outlive this.
  Selecting(const Context& context, const Scene& scene, const PreparedScene& prepared,
            std::function<void(const nlohmann::json&)> tell, std::function<void(const Answer&)> selected);
  ~Selecting();

  /// Marks to be answered in place of those that wait; `camera` is looked at first.
  void ask(Marks marks, int camera);
  /// What a click on this pixel would select, about; the last one that was asked for counts, marks come first.
  void hover(int camera, const Vec2f& pixel);

 private:
  struct Question {
    Marks marks;
    int camera = 0;
  };
  struct Hover {
    int camera = 0;
    Vec2f pixel;
  };
  void work();
  bool waiting();
  void answer(const Question& question);
  void answer(const Hover& hover);

  const Context& context_;
  const Scene& scene_;
  const PreparedScene& prepared_;
  const std::function<void(const nlohmann::json&)> tell_;
  const std::function<void(const Answer&)> selected_;
  GestureSteps steps_;  // of the last question; for the thread alone

  std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<Question> question_;
  std::optional<Hover> hover_;
  bool ended_ = false;
  std::thread thread_;
};

}  // namespace pliant
