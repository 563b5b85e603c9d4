#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/live/live_scene.h"

namespace pliant {

/// What a client of `pliant view` asks for: a JSON object of at most kMostMessage bytes, as text.
///   {"id": n, ...}             an answer with this id follows; without one there is none
///   "start": {"drivers": M, "clustered_to": c, "frame": f}   begins anew; all three are optional: a level of the page,
///                              which has M driving particles, and a frame of the clip; a refused one ends nothing
///   "commands": [...]          see parse_command; they take effect before the next frame
///   "frames": k                so many frames now, as fast as they come; the state after the last is the answer
///   "run": true | false        frames pass in real time, and each is sent as far as the client takes them; of one that
///                              takes long, states in between, too
///   "describe": true           what there is, as JSON
struct LiveRequest {
  std::optional<int> id;
  std::optional<LiveStart> start;
  std::vector<LiveCommand> commands;
  int frames = 0;
  std::optional<bool> run;
  bool describe = false;
};

constexpr size_t kMostMessage = 64 << 10;
constexpr int kMostFramesAsked = 600;

/// Throws Error{kUsage} where the text is anything else.  `drivers`: those of the motion, with which a start begins
/// that names no level.
LiveRequest parse_request(std::string_view text, const InteractionFrame& frame, size_t drivers);

/// A frame for a client, little-endian: 32 bytes {u32 magic "PLNT", u16 version 1, u16 type 1, u32 frame, u32 N, f64
/// time [s], u32 bytes of JSON, u32 bytes per particle}; the JSON, padded with spaces to a multiple of 4 bytes;
/// positions [N, 3] as u16, velocities [N, 3] and deformation gradients less the identity [N, 9] (rows) as i16.  The
/// JSON has the answer and how to decode: `low` and `size` [3] of the box that the positions lie in, scene units, and
/// `speed` (m/s) and `gradient` for 32767.  The answer is
///   "id"               of the request, where there was one
///   "substeps", "ms"   of the frame
///   "forces"           [[number, x, y, z], ...] in newtons, of what acted in the frame
///   "holds"            [[number, x, y, z], ...] in metres: where grabs that began took hold
///   "refused"          [[number, why], ...]: what could not begin; all else goes on
///   "failed"           why the solver failed, or null: what was begun has ended, and the settings are those of before
///   "within"           true where this is how far the next frame has come, which takes long: only to be shown
std::string state_message(const LiveSession& session, const LiveAnswer& answer, std::optional<int> id,
                          double metres_per_unit);
/// The message of a frame that is under way, for the `glance` of LiveSession::step; empty where it is not finite.
std::string message_within(const LiveSession& session, double metres_per_unit);

/// {"id", "error"} of a request that could not be done, or {"error"} of what fails by itself.  The third text that a
/// client is sent is {"said": text}, of what the program does beside the simulation: nothing needs to be done about it.
std::string error_message(std::optional<int> id, const std::string& text);

}  // namespace pliant
