#include "app/live/live_messages.h"

#include <gtest/gtest.h>

#include <cstring>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"
#include "tests/app/live/damaged_text.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

using nlohmann::json;

const InteractionFrame kFrame{0.5, {0, 0, 1}};

LiveRequest request(const std::string& text) { return parse_request(text, kFrame, 800); }

TEST(LiveMessages, ReadsEveryField) {
  const LiveRequest r = request(
      R"({"id": 7, "start": {"frame": 3}, "commands": [["end", 2]], "frames": 5, "run": true, "describe": false})");
  EXPECT_EQ(r.id, 7);
  EXPECT_EQ(r.start->drivers, 800u);
  EXPECT_EQ(r.start->frame, 3u);
  EXPECT_EQ(r.commands.size(), 1u);
  EXPECT_EQ(r.frames, 5);
  EXPECT_EQ(r.run, true);
  EXPECT_EQ(request(R"({"start": {"clustered_to": 50}})").start->drivers, 0u) << "as many as that level has";
}

TEST(LiveMessages, RefusesWhatIsNoRequest) {
  std::string deep(2000, '[');
  for (const std::string& text :
       {std::string(), std::string("x"), std::string("[]"), std::string("{\"id\": -1}"), std::string("{\"id\": 1.5}"),
        std::string("{\"frames\": 0}"), std::string("{\"frames\": 100000}"), std::string("{\"run\": 1}"),
        std::string("{\"what\": 1}"), std::string("{\"start\": 3}"), std::string("{\"start\": {\"frame\": -2}}"),
        std::string("{\"start\": {\"x\": 2}}"), std::string("{\"commands\": 3}"), std::string("{\"commands\": [3]}"),
        std::string("{\"id\": 1e400}"), "{\"commands\": " + deep, std::string(kMostMessage + 1, ' ')})
    EXPECT_THROW(request(text), Error) << text.substr(0, 60);
}

// Whatever bytes come: they are read or refused.
TEST(LiveMessages, SurvivesDamagedText) {
  const std::string good =
      R"({"id":1,"commands":[["begin",3,{"type":"grab","region":{"sphere":[0,0,0.1,0.02]},"max_force":4}],)"
      R"(["drag",3,0.1,0.2,-0.3],["set",2.5,0.5,0,0,-9.81],["end",3]],"frames":2})";
  ASSERT_EQ(request(good).commands.size(), 4u);
  Random random(3);
  int read = 0;
  for (int k = 0; k < 30'000; ++k) {
    try {
      request(damaged(good, random));
      ++read;
    } catch (const Error&) {
    }
  }
  EXPECT_GT(read, 100) << "some changes leave a request";
}

// What a client decodes lies within half a step of the quantisation.
TEST(LiveMessages, AStateComesBackWithinItsQuantisation) {
  const Particles particles = fixture::block<float>({0.03, 0.03, 0.06}, 0.01, 0.5, 2e4, 0.3, 800);
  SimulationState state = initial_state(particles);
  Random random(4);
  for (size_t i = 0; i < state.size(); ++i) {
    for (int a = 0; a < 3; ++a) state.v[i][a] = static_cast<float>(random.normal());
    state.F[i] += 0.1f * Mat3f::Constant(static_cast<float>(random.uniform()));
  }
  SimulateOptions options;
  const LiveSession session(options, particles, {}, state);
  LiveAnswer answer;
  answer.ms = 4.5;
  answer.holds = {{8, {1, 2, 3}}};
  answer.refused = {{9, "is in use"}};
  const std::string bytes = state_message(session, answer, 12, kFrame.metres_per_unit);

  const auto word = [&](size_t at) {
    uint32_t value;
    std::memcpy(&value, bytes.data() + at, 4);
    return value;
  };
  ASSERT_EQ(bytes.substr(0, 4), "PLNT");
  const size_t n = word(12), length = word(24);
  ASSERT_EQ(n, state.size());
  ASSERT_EQ(bytes.size(), 32 + length + 30 * n);
  ASSERT_EQ(length % 4, 0u);
  const json meta = json::parse(bytes.substr(32, length));
  EXPECT_EQ(meta["id"], 12);
  EXPECT_EQ(meta["holds"], json::parse("[[8, 1.0, 2.0, 3.0]]"));
  EXPECT_EQ(meta["refused"], json::parse(R"([[9, "is in use"]])"));
  EXPECT_TRUE(meta["failed"].is_null());
  const char* const body = bytes.data() + 32 + length;
  for (size_t i = 0; i < n; ++i) {
    for (size_t a = 0; a < 3; ++a) {
      uint16_t q;
      std::memcpy(&q, body + 2 * (3 * i + a), 2);
      const double low = meta["low"][a], size = meta["size"][a];
      EXPECT_NEAR(low + size * q / 65535, session.state().x[i][static_cast<int>(a)] / kFrame.metres_per_unit,
                  0.51 * size / 65535 + 1e-7);
      int16_t r;
      std::memcpy(&r, body + 2 * (3 * n + 3 * i + a), 2);
      const double speed = meta["speed"];
      EXPECT_NEAR(speed * r / 32767, session.state().v[i][static_cast<int>(a)], 0.51 * speed / 32767);
    }
    for (size_t k = 0; k < 9; ++k) {
      int16_t r;
      std::memcpy(&r, body + 2 * (6 * n + 9 * i + k), 2);
      const double gradient = meta["gradient"];
      EXPECT_NEAR(gradient * r / 32767 + (k % 4 == 0),
                  session.state().F[i](static_cast<int>(k) / 3, static_cast<int>(k) % 3),
                  0.51 * gradient / 32767 + 1e-6);
    }
  }
}

}  // namespace
}  // namespace pliant
