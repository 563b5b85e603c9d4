#include "segmentation/models/ram.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/utf8.h"
#include "segmentation/models/picture.h"

namespace pliant {

TagList TagList::read(const std::filesystem::path& file) {
  TagList tags;
  std::istringstream lines(read_text(file));
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::string place = "line " + std::to_string(++number);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) continue;
    const size_t tab = line.find('\t');
    float threshold = 0.68f;
    if (tab != std::string::npos) {
      char* end = nullptr;
      threshold = std::strtof(line.c_str() + tab + 1, &end);
      if (end == line.c_str() + tab + 1 || !(threshold >= 0 && threshold <= 1))
        throw input_error(file.string(), place, "has the threshold '" + line.substr(tab + 1) + "'",
                          "write NAME, a tab, and a number in 0..1");
    }
    const std::string name = line.substr(0, tab);
    if (as_utf8(name) != name)
      throw input_error(file.string(), place, "is not UTF-8", "convert the file to UTF-8, for example with iconv");
    tags.names.push_back(name);
    tags.thresholds.push_back(threshold);
  }
  if (tags.names.empty())
    throw input_error(file.string(), "", "has no names", "give the tag list of the network, one name per line");
  return tags;
}

Contract Ram::contract(const std::string& tags) {
  TensorLine logits{"logits", Tensor::Type::kFloat32, "1," + tags};
  logits.meaning = "one for each line of the tag list";
  return {"forward",
          {{"image", Tensor::Type::kFloat32, "1,3,S,S", -2.2, 2.7, "ImageNet mean and deviation, red first"}},
          {logits}};
}

Ram::Ram(std::unique_ptr<NeuralModule> module, TagList tags) : module_(std::move(module)), tags_(std::move(tags)) {
  size_ = module_->file().size_of("size", 384);
  contract_ = contract(std::to_string(tags_.names.size()));
  module_->verify(contract_, {{"S", size_}});
}

std::vector<Tag> Ram::tag(const ImageF& picture) {
  const Tensor logits =
      module_->run(contract_, {to_planes(resize_picture(picture, size_, size_), Normalisation::imagenet())})[0];
  std::vector<Tag> found;
  for (size_t k = 0; k < tags_.names.size(); ++k) {
    const float score = 1 / (1 + std::exp(-logits.values[k]));
    if (score > tags_.thresholds[k]) found.push_back({tags_.names[k], score});
  }
  std::stable_sort(found.begin(), found.end(), [](const Tag& a, const Tag& b) { return a.score > b.score; });
  return found;
}

}  // namespace pliant
