#include "app/live/live_client.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "app/page/interaction_numbers.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr size_t kMostWaiting = 1000;  // messages
constexpr size_t kMostPending = 4096;  // commands
constexpr auto kSaveEvery = std::chrono::seconds(1);
constexpr int kSaveShare = 50;  // of the time, at most one such part is spent on saving

/// The first live_NNNN.json that did not exist; it does now, so that no other client takes it.
fs::path fresh_file(const fs::path& folder) {
  for (int k = 1;; ++k) {
    const fs::path file = folder / fmt::format("live_{:04}.json", k);
    const int made = ::open(file.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    if (made >= 0) {
      ::close(made);
      return file;
    }
    if (errno != EEXIST)
      throw input_error(file.string(), "", std::string("cannot be written: ") + std::strerror(errno),
                        "check permissions and free space");
  }
}

}  // namespace

LiveClient::LiveClient(std::shared_ptr<const LiveScene> scene, fs::path recordings,
                       std::shared_ptr<Connection> connection, std::function<void(const std::string&)> warn,
                       std::chrono::milliseconds glance_every)
    : scene_(std::move(scene)),
      recordings_(std::move(recordings)),
      connection_(std::move(connection)),
      warn_(std::move(warn)),
      glance_every_(glance_every),
      thread_([this] { work(); }) {}

LiveClient::~LiveClient() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void LiveClient::receive(std::string text) {
  {
    const std::lock_guard lock(mutex_);
    text.resize(std::min(text.size(), kMostMessage + 1));  // longer ones are refused
    inbox_.push_back(std::move(text));
  }
  wake_.notify_one();
}

bool LiveClient::takes_more() const {
  const std::lock_guard lock(mutex_);
  return inbox_.size() < kMostWaiting;
}

bool LiveClient::is_unsaved() const {
  return session_ && !session_->history().empty() &&
         (session_->history().size() != saved_commands_ || session_->frames() != saved_frames_);
}

/// When there is something to do although no message comes.
std::optional<LiveClient::Clock::time_point> LiveClient::next_due() const {
  std::optional<Clock::time_point> next;
  if (running_) next = due_;
  if (is_unsaved()) next = next ? std::min(*next, save_due_) : save_due_;
  return next;
}

/// Handles messages as they come, and frames when they are due.
void LiveClient::work() {
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / scene_->setup.options.fps));
  std::unique_lock lock(mutex_);
  while (!ended_) {
    const auto woken = [&] { return ended_ || !inbox_.empty(); };
    if (const auto next = next_due())
      wake_.wait_until(lock, *next, woken);
    else
      wake_.wait(lock, woken);
    std::deque<std::string> messages;
    messages.swap(inbox_);
    lock.unlock();
    for (const std::string& text : messages)
      if (!ended_) handle(text);
    if (running_ && Clock::now() >= due_) {
      try {
        advance();
        if (connection_->idle()) send_state({});
      } catch (const std::exception& error) {
        running_ = false;
        connection_->send_text(error_message({}, error.what()));
      }
      // What is late stays late: slow motion.
      due_ = std::max(due_ + period, Clock::now());
    }
    if (is_unsaved() && Clock::now() >= save_due_) save(false);
    lock.lock();
  }
  lock.unlock();
  save(true);
}

void LiveClient::handle(const std::string& text) {
  std::optional<int> id;
  try {
    // The id goes into the answer even where the rest is refused.
    const json all = json::parse(text, nullptr, false);
    if (all.is_object() && all.contains("id") && all["id"].is_number_unsigned()) id = all["id"].get<int>();
    LiveRequest request = parse_request(text, scene_->frame(), scene_->drivers());
    id = request.id;
    if (request.start) begin(*request.start);
    if (!session_ && (!request.commands.empty() || request.frames > 0 || request.run.value_or(false)))
      begin({scene_->drivers(), 0, 0});
    if (pending_.size() + request.commands.size() > kMostPending)
      throw usage_error("message", "commands", "exceed the maximum number of pending commands",
                        "ask for frames, or run");
    pending_.insert(pending_.end(), std::make_move_iterator(request.commands.begin()),
                    std::make_move_iterator(request.commands.end()));
    if (request.run && *request.run != running_) {
      running_ = *request.run;
      due_ = Clock::now();
    }
    for (int f = 0; f < request.frames && !ended_; ++f) advance();
    if (request.frames > 0) {
      send_state(id);
    } else if (id) {
      json answer = request.describe ? description() : json::object();
      answer["id"] = *id;
      connection_->send_text(answer.dump());
    }
  } catch (const Error& error) {
    connection_->send_text(error_message(id, error.what()));
  } catch (const std::exception& error) {
    connection_->send_text(error_message(id, std::string("failed: ") + error.what()));
  }
}

void LiveClient::begin(const LiveStart& start) {
  const bool same = body_ && (start.drivers == 0 || start.drivers == start_.drivers) &&
                    start.clustered_to == start_.clustered_to && start.frame == start_.frame;
  // A start that is refused leaves the session that runs.
  std::unique_ptr<LiveBody> body = same ? std::move(body_) : std::make_unique<LiveBody>(*scene_, start, "start");
  save(true);
  session_.reset();
  pending_.clear();
  body_ = std::move(body);
  malloc_trim(0);  // what a body that flew far made the solver take
  answer_ = {};
  running_ = false;
  start_ = start;
  start_.drivers = body_->level.driving_position.size();
  recording_.emplace(*scene_, start_);
  session_ =
      std::make_unique<LiveSession>(scene_->setup.options, body_->body.particles, scene_->setup.held, body_->state);
}

void LiveClient::advance() {
  std::vector<LiveCommand> commands;
  commands.swap(pending_);
  shown_ = Clock::now();
  LiveAnswer next = session_->step(commands, [this] { show_within(); });
  next.holds.insert(next.holds.begin(), answer_.holds.begin(), answer_.holds.end());
  next.refused.insert(next.refused.begin(), answer_.refused.begin(), answer_.refused.end());
  if (next.failed.empty()) next.failed = answer_.failed;
  answer_ = std::move(next);
}

/// Slow motion in place of a picture that stands; nobody waits for the frame of a client that has left.
void LiveClient::show_within() {
  if (ended_) throw Error(Failure::kInterrupted, "view", "", "the client has left", "connect again");
  if (!running_ || Clock::now() - shown_ < glance_every_) return;
  shown_ = Clock::now();
  if (!connection_->idle()) return;
  const std::string message = message_within(*session_, scene_->scene.metres_per_unit);
  if (!message.empty()) connection_->send_bytes(message);
}

void LiveClient::send_state(std::optional<int> id) {
  connection_->send_bytes(state_message(*session_, answer_, id, scene_->scene.metres_per_unit));
  answer_ = {};
}

void LiveClient::save(bool ended) {
  if (!session_ || session_->history().empty()) return;
  const Clock::time_point before = Clock::now();
  try {
    fs::create_directories(recordings_);
    if (file_.empty()) file_ = fresh_file(recordings_);
    write_text(file_, recording_->of(*session_));
    saved_commands_ = session_->history().size();
    saved_frames_ = session_->frames();
    unkept_ = false;
  } catch (const std::exception& error) {
    const std::string said = std::string("the recording cannot be kept: ") + error.what();
    if (!unkept_) connection_->send_text(error_message({}, said));
    if (!unkept_ && warn_) warn_(said);
    unkept_ = true;
    // Nothing was written to it yet.
    std::error_code none;
    if (saved_commands_ == 0 && !file_.empty()) fs::remove(std::exchange(file_, {}), none);
  }
  const Clock::time_point now = Clock::now();
  save_due_ = now + std::max<Clock::duration>(kSaveEvery, kSaveShare * (now - before));
  if (!ended) return;
  file_.clear();
  saved_commands_ = 0;
  saved_frames_ = 0;
}

json LiveClient::description() const {
  const SimulateOptions& options = scene_->setup.options;
  json held = json::array();
  for (const Interaction& it : scene_->setup.held) held.push_back(numbers_of(it));
  const Vec3d& up = scene_->scene.up;
  json out = {{"drivers", scene_->drivers()},
              {"fps", options.fps},
              {"metres_per_unit", scene_->scene.metres_per_unit},
              {"up", {up.x(), up.y(), up.z()}},
              {"gravity", {options.gravity.x(), options.gravity.y(), options.gravity.z()}},
              {"damping_time", options.damping_time},
              {"height", scene_->setup.height},
              {"held", held}};
  if (body_) out["mass"] = body_->body.particles.total_mass();
  return out;
}

}  // namespace pliant
