#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "app/choose/choose_request.h"
#include "app/choose/selecting.h"
#include "app/live/live_site.h"
#include "app/predict/prepare_object.h"

namespace pliant {

/// Why marks are refused for as long as a scene could not be prepared.
inline constexpr const char* kUnprepared = "cannot be answered: the scene could not be prepared";

/// The choice of an object in the browser.  Marks are answered at once; what is written to the run directory is, in a
/// thread of its own, one request at a time, by the stages of the commands: what is done stays, and a command goes on
/// from it.  A chosen object is extracted, its material predicted, and a few frames are simulated; then the site shows
/// it to be moved, and the hole is repaired.
///
/// A client sends a JSON object with one of
///   "select": {"marks": [{"kind": "box", "click", "stroke" or "grow", "text": "..."}, ...], "camera": N}   select the
///                                                   object behind these marks, as `pliant segment` does, in the order
///                                                   in which they were made, see marks.h; "boxes": [...], "clicks":
///                                                   [...], "strokes": [...], "grow": n are more of them, in this
///                                                   order; answered at once, see selecting.h, and written when no
///                                                   other marks come for a while: {"kept": {"things", "views"}}, see
///                                                   choose_data. The mask of `camera`, which may be left out, is
///                                                   first.  Without marks, those before are not answered any more.
///                                                   Refused where the scene could not be prepared
///   "hover": [N, x, y]                              what a click there would select, about
///   "find": true                                    find the objects that the scene has, as `pliant segment` does:
///                                                   those of its masks, or free-standing ones
///   "make": {"object": id, "label": "..."}          make it ready to be moved; the label, which may be left out, says
///                                                   what it is; 0 is what the last marks select, written if it is not
///                                                   there, and refused where there are none
///   "name": {"object": id, "name": "..."}           name it, as `pliant segment edit --name` does; a selection keeps
///                                                   its name until one that shares no mark with it
///   "cancel": true                                  stops what is under way, and takes back what waits
/// Answers, to all clients: {"busy": what, or ""}, {"progress": {"text", "fraction"}}, {"said", "warning"},
/// {"failed": text}, and {"reload": true} where the address now shows something else; to the one, {"error": text}.
/// Who comes while marks are not written yet is told {"marks": as in "select"}.  What was selected is written at the
/// end too.  Pages that move the object are told {"said": text} when its hole is repaired, or why it cannot be.  What
/// fails although nobody asked for it is told on the console too, and to those who come later.
class Chooser {
 public:
  /// Of a segmented run; `stages` are those that make an object ready.  Context, run and site must outlive it; clients
  /// must be gone before it.
  Chooser(const Context& context, RunDirectory& run, Scene scene, LiveSite& site, ObjectStages stages = {});
  ~Chooser();

  /// Shows the pictures and objects that are there, and returns them.
  nlohmann::json show();

 private:
  class Visitor;
  void stop();
  void receive(const std::string& text, Connection& from);
  void work();
  void carry_out(const std::string& name, const std::function<void()>& work);
  /// `behind` is the context of keep, which a client does not cancel.
  void carry_out(const Context& context, const Context& behind, const ChooseRequest& request);
  void prepare(const Context& context);
  void select(const ChooseRequest& request);
  void take_answer(const Selecting::Answer& answer);
  /// Has `keep` write what the last marks select, once they have been answered; throws where they select nothing.
  void take_selection();
  /// Writes what was selected last, where that has not been done, and tells what is there now.
  void keep(const Context& context);
  bool write(const Context& context);  // whether there was anything to be written
  /// Writes at the end what was selected shortly before, or warns that it is not written.
  void write_last(const Context& context);
  /// Extracts, predicts and simulates an object, has the site show it, and repairs what is behind it.
  void make(const Context& context, const ChooseRequest& request);
  /// Fills the hole behind an object that the site shows on a screen to be moved.
  void repair(const Context& context, const Scene& scene, LiveScreen screen);
  void name_object(const Context& context, uint32_t object, const std::string& name);
  void tell_kept(const nlohmann::json& shown);
  static std::string text_of(const nlohmann::json& message);
  void tell(const nlohmann::json& message);
  void tell_locked(const nlohmann::json& message);  // where mutex_ is held

  const Context& context_;
  RunDirectory& run_;
  const Scene scene_;
  LiveSite& site_;
  const ObjectStages stages_;
  PreparedScene prepared_;

  std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::weak_ptr<Connection>> visitors_;
  std::optional<ChooseRequest> request_;  // that waits or is under way
  bool begun_ = false;                    // it is under way
  bool keeping_ = false;                  // the objects are being replaced by the selection
  nlohmann::json trouble_;                // a failure behind, for those who come later; null = there was none
  std::optional<ChooseRequest> early_;    // to select, before the scene was prepared
  MadeSelection made_;                    // that is there, without marks = there is none; next marks keep its name
  Marks wanted_;                          // by the last `select`, since objects were found; empty = none
  Marks last_;                            // that were wanted
  std::optional<Marks> asked_;            // marks that are not answered yet
  std::string failed_;                    // why the last ones select nothing
  std::optional<Marks> selected_;         // by marks, not written yet
  std::chrono::steady_clock::time_point selected_at_;
  std::unique_ptr<Selecting> selecting_;  // null while the scene is being prepared
  std::atomic<bool> cancelled_ = false, ended_ = false;
  std::thread thread_;
};

}  // namespace pliant
