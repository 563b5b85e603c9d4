#include "segmentation/select/gesture_prompts.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "gaussians/base/error.h"
#include "gaussians/io/files/text.h"

namespace pliant {
namespace {

constexpr const char* kBoxForm = "V,x0,y0,x1,y1: a camera and two corners in pixels of its image";
constexpr const char* kClickForm = "V,x,y: a camera and a pixel of its image";
constexpr const char* kStrokeForm = "fg or bg,V,x0,y0,x1,y1,...: a camera and pixels of its image";

/// The comma-separated words of a text whose word `at` is a camera: the longest name among those with commas, where one
/// stands there, else all up to the next comma.
std::vector<std::string> words_of(const std::string& text, size_t at, const std::vector<Camera>& cameras) {
  std::vector<std::string> words = split(text, ',');
  const size_t begin = at == 0 ? 0 : text.find(',') + 1;
  if (words.size() <= at) return words;
  std::string longest;
  for (const Camera& camera : cameras)
    if (camera.name.size() > longest.size() && camera.name.find(',') != std::string::npos &&
        text.compare(begin, camera.name.size() + 1, camera.name + ",") == 0)
      longest = camera.name;
  if (longest.empty()) return words;
  const auto first = words.begin() + static_cast<std::ptrdiff_t>(at);
  *first = longest;
  words.erase(first + 1, first + std::count(longest.begin(), longest.end(), ',') + 1);
  return words;
}

/// The comma-separated words of one option, of which the word `at` is a camera, and what is read from them.
struct Words {
  std::string option, text, form;
  const std::vector<Camera>& cameras;
  std::vector<std::string> words;

  Words(std::string option_name, const std::string& value, std::string what, const std::vector<Camera>& scene_cameras,
        size_t at = 0)
      : option(std::move(option_name)),
        text(value),
        form(std::move(what)),
        cameras(scene_cameras),
        words(words_of(text, at, cameras)) {}

  Error wrong(const std::string& problem, const std::string& remedy) const {
    return usage_error(option, "", "'" + text + "' " + problem, remedy);
  }
  Error wrong_form(const std::string& problem) const { return wrong(problem, "give " + form); }

  /// By number where '#' stands in front, else by name or, where no camera has that, by number.
  int camera(size_t at) const {
    const std::string& name = words[at];
    const bool numbered = name.starts_with('#');
    for (size_t c = 0; c < cameras.size() && !numbered; ++c)
      if (cameras[c].name == name) return static_cast<int>(c);
    const char* const digits = name.c_str() + (numbered ? 1 : 0);
    char* stop = nullptr;
    const long number = std::strtol(digits, &stop, 10);
    if (*digits != 0 && *stop == 0 && number >= 0 && number < static_cast<long>(cameras.size()))
      return static_cast<int>(number);
    throw wrong("names the camera '" + name + "', which the scene does not have",
                "give a number from #0 to #" + std::to_string(cameras.size() - 1) + " or a name such as '" +
                    cameras.front().name + "'; `pliant render SCENE --out FOLDER` writes the images under these names");
  }

  Vec2f point(size_t at, const Camera& camera) const {
    Vec2f x;
    for (int k = 0; k < 2; ++k) {
      const std::string& word = words[at + k];
      char* stop = nullptr;
      x[k] = std::strtof(word.c_str(), &stop);
      if (word.empty() || *stop != 0 || !std::isfinite(x[k]))
        throw wrong_form("holds '" + word + "', which is not a number");
    }
    if (x.x() < 0 || x.y() < 0 || x.x() > static_cast<float>(camera.width) || x.y() > static_cast<float>(camera.height))
      throw wrong("has the point " + words[at] + "," + words[at + 1] + " outside the image of '" + camera.name + "'",
                  "that image is " + std::to_string(camera.width) + " pixels wide and " +
                      std::to_string(camera.height) + " high");
    return x;
  }
};

}  // namespace

void add_box(const std::string& text, const std::vector<Camera>& cameras, Gesture& gesture) {
  const Words words("--box", text, kBoxForm, cameras);
  if (words.words.size() != 5)
    throw words.wrong_form("has " + std::to_string(words.words.size()) + " values, 5 are needed");
  BoxPrompt box;
  box.camera = words.camera(0);
  const Vec2f a = words.point(1, cameras[box.camera]), b = words.point(3, cameras[box.camera]);
  box.x0 = std::min(a.x(), b.x());
  box.x1 = std::max(a.x(), b.x());
  box.y0 = std::min(a.y(), b.y());
  box.y1 = std::max(a.y(), b.y());
  if (!(box.x1 - box.x0 >= 4 && box.y1 - box.y0 >= 4))
    throw words.wrong("is a box of less than 4 x 4 pixels", "give two opposite corners around the object");
  for (const BoxPrompt& other : gesture.boxes)
    if (other.camera == box.camera)
      throw words.wrong("is a second box in the camera '" + cameras[box.camera].name + "'",
                        "give one box per camera, around the whole object");
  gesture.boxes.push_back(box);
}

void add_click(const std::string& text, const std::vector<Camera>& cameras, float width, Gesture& gesture) {
  const Words words("--click", text, kClickForm, cameras);
  if (words.words.size() != 3)
    throw words.wrong_form("has " + std::to_string(words.words.size()) + " values, 3 are needed");
  StrokePrompt stroke;
  stroke.camera = words.camera(0);
  stroke.width = width;
  stroke.points = {words.point(1, cameras[stroke.camera])};
  gesture.strokes.push_back(stroke);
}

void add_stroke(const std::string& text, const std::vector<Camera>& cameras, float width, Gesture& gesture) {
  const Words words("--stroke", text, kStrokeForm, cameras, 1);
  if (words.words.size() < 4 || words.words.size() % 2 != 0)
    throw words.wrong_form("has " + std::to_string(words.words.size()) +
                           " values, 4 or a larger even number are needed");
  if (words.words[0] != "fg" && words.words[0] != "bg") throw words.wrong_form("begins with '" + words.words[0] + "'");
  StrokePrompt stroke;
  stroke.foreground = words.words[0] == "fg";
  stroke.width = width;
  stroke.camera = words.camera(1);
  for (size_t at = 2; at < words.words.size(); at += 2)
    stroke.points.push_back(words.point(at, cameras[stroke.camera]));
  gesture.strokes.push_back(stroke);
}

}  // namespace pliant
