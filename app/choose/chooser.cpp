#include "app/choose/chooser.h"

#include <omp.h>

#include <nlohmann/json.hpp>

#include "app/choose/opener.h"
#include "app/segment/prepared_scene_file.h"
#include "app/segment/segment_stage.h"
#include "gaussians/base/error.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr std::chrono::milliseconds kSettled(1500);  // without new marks a selection is written

}  // namespace

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
    : context_(context),
      run_(run),
      scene_(std::move(scene)),
      site_(site),
      stages_(std::move(stages)),
      made_(made_selection(run_, scene_)),
      wanted_(made_.marks),
      last_(made_.marks),
      thread_([this] { work(); }) {
  site_.at_end([this] { stop(); });
}

Chooser::~Chooser() { stop(); }

void Chooser::stop() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
  selecting_.reset();
}

json Chooser::show() {
  Marks marks;
  {
    const std::lock_guard lock(mutex_);
    marks = wanted_.empty() ? made_.marks : wanted_;
  }
  json data = choose_data(run_, scene_, marks);
  site_.show({choose_page(data), [this](std::shared_ptr<Connection> connection) {
                const std::lock_guard lock(mutex_);
                std::erase_if(visitors_, [](const auto& visitor) { return visitor.expired(); });
                visitors_.push_back(connection);
                if (request_) connection->send_text(json({{"busy", name_of(request_->kind)}}).dump());
                if (!trouble_.is_null()) connection->send_text(text_of(trouble_));
                if (!wanted_.empty() && wanted_ != made_.marks)
                  connection->send_text(text_of({{"marks", marks_json(wanted_)}}));
                return std::make_unique<Visitor>(*this, std::move(connection));
              }});
  return data;
}

void Chooser::receive(const std::string& text, Connection& from) {
  try {
    const ChooseRequest request = parse_choose_request(text);
    const std::lock_guard lock(mutex_);
    if (request.kind == ChooseRequest::Kind::kCancel) {
      if (request_ && !begun_) {
        request_.reset();
        tell_locked({{"busy", ""}});
        tell_locked({{"failed", "Cancelled."}});
        return;
      }
      cancelled_ = true;
      wake_.notify_one();
      return;
    }
    if (request.kind == ChooseRequest::Kind::kHover) {
      if (selecting_ && !request_ && request.camera < static_cast<int>(scene_.cameras.size()))
        selecting_->hover(request.camera, request.pixel);
      return;
    }
    if (request_) throw refused_request("", "was sent while another request is in progress; wait, or cancel it");
    if (keeping_ && request.object != 0)
      throw refused_request("object", "has no meaning now: the objects are being replaced; choose again");
    cancelled_ = false;
    if (request.kind == ChooseRequest::Kind::kSelect) return select(request);
    request_ = request;
    tell_locked({{"busy", name_of(request.kind)}});
  } catch (const std::exception& error) {
    from.send_text(text_of({{"error", error.what()}}));
    return;
  }
  wake_.notify_one();
}

void Chooser::select(const ChooseRequest& request) {
  wanted_ = request.marks;
  asked_.reset();
  early_.reset();
  selected_.reset();
  failed_.clear();
  if (request.marks.empty()) return;
  if (!share_one(request.marks, last_)) made_.name.clear();
  last_ = request.marks;
  asked_ = request.marks;
  if (selecting_) return selecting_->ask(request.marks, request.camera);
  // Without it nothing but the preparation can have failed.
  if (!trouble_.is_null()) throw refused_request("select", kUnprepared);
  early_ = request;
}

void Chooser::take_answer(const Selecting::Answer& answer) {
  {
    const std::lock_guard lock(mutex_);
    if (asked_ != answer.marks) return;
    asked_.reset();
    failed_ = answer.failed;
    if (failed_.empty()) selected_ = answer.marks;
    selected_at_ = std::chrono::steady_clock::now();
  }
  wake_.notify_one();
}

void Chooser::work() {
  const int threads = context_.threads > 0 ? context_.threads : omp_get_max_threads();
  Progress progress(true);
  tell_progress(progress, context_, [this](const json& message) { tell(message); });
  const auto ended = [this] { return ended_ || context_.interrupted(); };
  const Context behind{progress, ended, context_.seed, context_.threads, context_.overwrite};
  const Context context{progress, [&] { return cancelled_ || ended(); }, context_.seed, context_.threads,
                        context_.overwrite};
  omp_set_num_threads(threads);
  carry_out("", [&] { prepare(behind); });
  for (;;) {
    std::string doing;
    {
      std::unique_lock lock(mutex_);
      const auto due = [&] { return selected_ && std::chrono::steady_clock::now() >= selected_at_ + kSettled; };
      while (!ended() && !request_ && !due()) {
        if (selected_)
          wake_.wait_until(lock, selected_at_ + kSettled);
        else
          wake_.wait(lock);
      }
      if (ended()) break;
      if (request_) doing = name_of(request_->kind);
      begun_ = !doing.empty();
      keeping_ = doing.empty();
    }
    omp_set_num_threads(threads);
    if (doing.empty())
      carry_out(doing, [&] { keep(behind); });
    else
      carry_out(doing, [&] { carry_out(context, behind, *request_); });
  }
  write_last({progress, [] { return false; }, context_.seed, context_.threads, context_.overwrite});
}

/// Work for the request of this name, of whose end everyone is told; that without a name goes on behind.
void Chooser::carry_out(const std::string& name, const std::function<void()>& work) {
  json failure;
  bool cancelled = false;
  try {
    work();
  } catch (const Error& error) {
    cancelled = error.failure == Failure::kInterrupted;
    failure = {{"failed", cancelled ? "Cancelled." : error.what()}};
  } catch (const std::exception& error) {
    failure = {{"failed", error.what()}};
  }
  const std::lock_guard lock(mutex_);
  keeping_ = false;
  if (name.empty() && !cancelled) {
    trouble_ = failure;
    if (!failure.is_null()) context_.progress.warn("view: " + failure["failed"].get<std::string>());
  }
  if (!name.empty()) {
    request_.reset();
    begun_ = false;
    tell_locked({{"busy", ""}});
  }
  if (!failure.is_null()) tell_locked(failure);
}

void Chooser::prepare(const Context& context) {
  prepared_ = prepared_scene(context, run_, scene_);
  const std::lock_guard lock(mutex_);
  selecting_ = std::make_unique<Selecting>(
      context_, scene_, prepared_, [this](const json& message) { tell(message); },
      [this](const Selecting::Answer& answer) { take_answer(answer); });
  if (early_) selecting_->ask(early_->marks, early_->camera);
}

void Chooser::carry_out(const Context& context, const Context& behind, const ChooseRequest& request) {
  using Kind = ChooseRequest::Kind;
  if (request.kind != Kind::kFind && request.object == 0) take_selection();
  {
    // Nothing of the marks is written once they count no more: it would replace the objects that are listed.
    const std::lock_guard lock(mutex_);
    if (request.kind == Kind::kFind || request.object != 0) {
      asked_.reset();
      selected_.reset();
    }
  }
  keep(behind);
  if (context.interrupted()) throw Error(Failure::kInterrupted, "view", "", "interrupted", "choose again");
  if (request.kind == Kind::kMake) return make(context, request);
  if (request.kind == Kind::kName) {
    const uint32_t object = request.object == 0 ? SelectionShape::kObject : request.object;
    name_object(context, object, request.label);
    {
      const std::lock_guard lock(mutex_);
      if (!made_.marks.empty() && object == SelectionShape::kObject) made_.name = request.label;
    }
    tell_kept(show());
    return;
  }
  run_segment(context, run_, scene_, {});
  {
    const std::lock_guard lock(mutex_);
    made_ = {};
    wanted_ = {};
    last_ = {};
  }
  show();
  tell({{"reload", true}});
}

std::string Chooser::text_of(const json& message) {
  return message.dump(-1, ' ', false, json::error_handler_t::replace);
}

void Chooser::tell(const json& message) {
  const std::lock_guard lock(mutex_);
  tell_locked(message);
}

void Chooser::tell_locked(const json& message) {
  const std::string text = text_of(message);
  for (const std::weak_ptr<Connection>& visitor : visitors_)
    if (const auto connection = visitor.lock()) connection->send_text(text);
}

}  // namespace pliant
