#include "app/choose/chooser.h"

#include <omp.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/live/live_view.h"
#include "app/segment/segment_stage.h"
#include "gaussians/base/error.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr size_t kMostMarks = 200, kLongestMark = 20'000, kLongestLabel = 100;  // characters
constexpr double kSimulated = 0.1;  // s, of the motion that the page begins with

Error wrong(const std::string& field, const std::string& problem) {
  return usage_error("message", field, problem, "see app/choose/chooser.h");
}

std::vector<std::string> marks_of(const json& select, const char* field) {
  std::vector<std::string> out;
  if (!select.contains(field)) return out;
  if (!select[field].is_array() || select[field].size() > kMostMarks) throw wrong(field, "is no list of marks");
  for (const json& mark : select[field]) {
    if (!mark.is_string() || mark.get_ref<const std::string&>().size() > kLongestMark)
      throw wrong(field, "has a mark that is no text");
    out.push_back(mark);
  }
  return out;
}

const char* name_of(ChooseRequest::Kind kind) {
  switch (kind) {
    case ChooseRequest::Kind::kSelect:
      return "select";
    case ChooseRequest::Kind::kFind:
      return "find";
    case ChooseRequest::Kind::kMake:
      return "make";
    case ChooseRequest::Kind::kCancel:
      break;
  }
  return "cancel";
}

}  // namespace

ChooseRequest parse_choose_request(std::string_view text) {
  const json all = json::parse(text, nullptr, false);
  if (!all.is_object() || all.size() != 1) throw wrong("", "is no JSON object with one request");
  const std::string& name = all.begin().key();
  const json& value = all.begin().value();
  ChooseRequest out;
  if (name == "select") {
    if (!value.is_object()) throw wrong(name, "is no object");
    out.kind = ChooseRequest::Kind::kSelect;
    out.marks = {marks_of(value, "clicks"), marks_of(value, "strokes")};
    if (out.marks.clicks.empty() && out.marks.strokes.empty()) throw wrong(name, "has no marks");
  } else if (name == "make") {
    if (!value.is_object() || !value.contains("object") || !value["object"].is_number_unsigned() ||
        value["object"].get<uint64_t>() > UINT32_MAX)
      throw wrong(name, "names no object");
    out.kind = ChooseRequest::Kind::kMake;
    out.object = value["object"];
    if (value.contains("label")) {
      if (!value["label"].is_string() || value["label"].get_ref<const std::string&>().size() > kLongestLabel)
        throw wrong("label", "is no short text");
      out.label = value["label"];
    }
  } else if ((name == "find" || name == "cancel") && value == true) {
    out.kind = name == "find" ? ChooseRequest::Kind::kFind : ChooseRequest::Kind::kCancel;
  } else {
    throw wrong(name, "is not known");
  }
  return out;
}

/// A browser that shows the choice.
class Chooser::Visitor : public Client {
 public:
  Visitor(Chooser& chooser, std::shared_ptr<Connection> connection)
      : chooser_(chooser), connection_(std::move(connection)) {}
  void receive(std::string text) override { chooser_.receive(text, *connection_); }

 private:
  Chooser& chooser_;
  const std::shared_ptr<Connection> connection_;
};

Chooser::Chooser(const Context& context, RunDirectory& run, Scene scene, LiveSite& site, ObjectStages stages)
    : context_(context), run_(run), scene_(std::move(scene)), site_(site), stages_(std::move(stages)), thread_([this] {
        work();
      }) {}

Chooser::~Chooser() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void Chooser::show() {
  site_.show({choose_page(choose_data(run_, scene_, marks_)), [this](std::shared_ptr<Connection> connection) {
                const std::lock_guard lock(mutex_);
                std::erase_if(visitors_, [](const auto& visitor) { return visitor.expired(); });
                visitors_.push_back(connection);
                if (request_) connection->send_text(json({{"busy", name_of(request_->kind)}}).dump());
                return std::make_unique<Visitor>(*this, std::move(connection));
              }});
}

void Chooser::receive(const std::string& text, Connection& from) {
  try {
    const ChooseRequest request = parse_choose_request(text);
    if (request.kind == ChooseRequest::Kind::kCancel) {
      cancelled_ = true;
      return;
    }
    const std::lock_guard lock(mutex_);
    if (request_) throw wrong("", "comes while another is carried out; wait, or cancel that");
    request_ = request;
    cancelled_ = false;
  } catch (const std::exception& error) {
    from.send_text(json({{"error", error.what()}}).dump(-1, ' ', false, json::error_handler_t::replace));
    return;
  }
  wake_.notify_one();
}

void Chooser::work() {
  const int threads = context_.threads > 0 ? context_.threads : omp_get_max_threads();
  Progress progress(true);
  progress.listen([this](const ProgressEvent& event) {
    if (event.fraction >= 0) return tell({{"progress", {{"text", event.text}, {"fraction", event.fraction}}}});
    if (!event.warning) context_.progress.say(event.text);
    tell({{"said", event.text}, {"warning", event.warning}});
  });
  const Context context{progress, [this] { return cancelled_ || ended_ || context_.interrupted(); }, context_.seed,
                        context_.threads, context_.overwrite};
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return ended_ || request_; });
      if (ended_) return;
    }
    tell({{"busy", name_of(request_->kind)}});
    omp_set_num_threads(threads);
    json failure;
    try {
      carry_out(context, *request_);
    } catch (const Error& error) {
      failure = {{"failed", error.failure == Failure::kInterrupted ? "Cancelled." : error.what()}};
    } catch (const std::exception& error) {
      failure = {{"failed", error.what()}};
    }
    {
      const std::lock_guard lock(mutex_);
      request_.reset();
    }
    tell({{"busy", ""}});
    if (!failure.is_null()) tell(failure);
  }
}

void Chooser::carry_out(const Context& context, const ChooseRequest& request) {
  if (request.kind == ChooseRequest::Kind::kMake) {
    Scene scene = scene_;  // which the object may scale
    ObjectStages stages = stages_;
    stages.extract.object = std::to_string(request.object);
    stages.predict.label = request.label;
    SimulateStage simulate;
    simulate.duration = kSimulated;
    prepare_object(context, run_, scene, stages, simulate);
    run_simulate(context, run_, scene, simulate);
    site_.show(live_screen(context, run_, scene));
    tell({{"reload", true}});
    // The hole closes behind the object while it is being moved; the page has it when it is loaded again.
    omp_set_num_threads(std::max(1, omp_get_max_threads() / 2));
    run_repair(context, run_, scene, {});
    site_.show(live_screen(context, run_, scene));
    return;
  }
  SegmentStage segment;
  segment.automatic = request.kind == ChooseRequest::Kind::kFind;
  segment.clicks = request.marks.clicks;
  segment.strokes = request.marks.strokes;
  run_segment(context, run_, scene_, segment);
  marks_ = request.marks;
  show();
  tell({{"reload", true}});
}

void Chooser::tell(const json& message) {
  const std::string text = message.dump(-1, ' ', false, json::error_handler_t::replace);
  const std::lock_guard lock(mutex_);
  for (const std::weak_ptr<Connection>& visitor : visitors_)
    if (const auto connection = visitor.lock()) connection->send_text(text);
}

}  // namespace pliant
