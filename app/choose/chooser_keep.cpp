// What is selected is written to the run directory.

#include <nlohmann/json.hpp>

#include "app/choose/chooser.h"
#include "app/segment/edit_stage.h"
#include "app/segment/segment_stage.h"
#include "gaussians/base/error.h"

namespace pliant {
using nlohmann::json;

void Chooser::take_selection() {
  std::unique_lock lock(mutex_);
  if (wanted_.empty()) throw refused_request("object", "0 names no selection that is there; select again");
  wake_.wait(lock, [&] { return ended_ || cancelled_ || !asked_ || !selecting_; });
  if (ended_ || cancelled_) throw Error(Failure::kInterrupted, "view", "", "interrupted", "select again");
  if (asked_) throw refused_request("select", kUnprepared);
  if (!failed_.empty()) throw std::runtime_error(failed_);
  selected_ = wanted_;
}

void Chooser::keep(const Context& context) {
  if (write(context)) tell_kept(show());
}

bool Chooser::write(const Context& context) {
  std::optional<Marks> marks;
  MadeSelection before;
  {
    const std::lock_guard lock(mutex_);
    marks.swap(selected_);
    before = made_;
    if (!marks || *marks == made_.marks) return false;
    made_.marks = {};
  }
  // The name of an earlier selection is given anew below and is no edit to be kept beside the next one.
  const json edits = run_.note("edits"), record = run_.last_record("segment");
  if (!before.marks.empty()) run_.set_note("edits", {});
  try {
    run_segment(context, run_, scene_, segment_by(*marks));
  } catch (...) {
    const bool stays = run_.last_record("segment") == record;
    if (stays) run_.set_note("edits", edits);
    const std::lock_guard lock(mutex_);
    if (stays) made_.marks = before.marks;
    if (context.interrupted() && !asked_ && wanted_ == *marks) selected_ = marks;  // for write_last
    throw;
  }
  {
    const std::lock_guard lock(mutex_);
    made_.marks = *std::move(marks);
  }
  if (!before.name.empty()) name_object(context, SelectionShape::kObject, before.name);
  return true;
}

void Chooser::write_last(const Context& context) {
  bool answered = true;
  {
    const std::lock_guard lock(mutex_);
    answered = !asked_;
  }
  if (!answered) context_.progress.warn("view: the last selection is not written: it had not been found yet");
  try {
    write(context);
  } catch (const std::exception& error) {
    context_.progress.warn(std::string("view: the last selection could not be written: ") + error.what());
  }
}

void Chooser::name_object(const Context& context, uint32_t object, const std::string& name) {
  EditStage edit;
  edit.edits.push_back(ObjectEdit::parse(ObjectEdit::Kind::kName, std::to_string(object) + "=" + name));
  run_edit(context, run_, scene_, edit);
}

void Chooser::tell_kept(const json& shown) {
  json views = json::array();
  for (const json& view : shown.at("views")) views.push_back({{"camera", view.at("camera")}, {"ids", view.at("ids")}});
  tell({{"kept", {{"things", shown.at("things")}, {"views", views}}}});
}

}  // namespace pliant
