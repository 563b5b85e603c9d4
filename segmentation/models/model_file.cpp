#include "segmentation/models/model_file.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/files/zip_archive.h"
#include "segmentation/models/file_kind.h"

namespace pliant {
namespace {

/// The folder that all entries of a PyTorch archive share, from the first local header of the zip.
std::string root_of_zip(const std::filesystem::path& file) {
  std::string head(30 + 4096, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<size_t>(in.gcount()));
  if (head.size() < 30) return "";
  const size_t length = static_cast<uint8_t>(head[26]) | static_cast<size_t>(static_cast<uint8_t>(head[27])) << 8;
  const std::string name = head.substr(30, length);
  return name.substr(0, name.find('/'));
}

bool readable(ZipArchive& zip, const std::string& entry, uint64_t most, std::string& text) {
  try {
    text = zip.read(entry, most);
    return true;
  } catch (const Error&) {
    return false;
  }
}

void read_torch_script(const std::filesystem::path& file, ModelFile& model) {
  constexpr uint64_t kMost = 64 << 20;
  const std::string root = root_of_zip(file) + "/";
  ZipArchive zip(file);
  std::string text;
  if (!readable(zip, root + "constants.pkl", kMost, text)) {
    if (readable(zip, root + "data.pkl", kMost, text))
      throw input_error(file.string(), "", "is a checkpoint of torch.save: weights without the network",
                        "export the network as TorchScript with a script of segmentation/models/export");
    throw input_error(file.string(), "", "is a zip archive but not TorchScript", "give an ONNX or TorchScript file");
  }
  model.format = ModelFile::Format::kTorchScript;
  if (readable(zip, root + "extra/pliant.json", 1 << 20, text)) model.description = text;
}

/// The outline of ONNX; what is not ONNX is named by what it is, where its first bytes say so.
OnnxGraph read_onnx(const std::string& bytes, const std::string& file) {
  try {
    return read_onnx_graph(bytes, file);
  } catch (const Error&) {
    const std::string kind = kind_of_file(bytes);
    if (kind.empty()) throw;
    throw input_error(file, "", "is " + kind + ", not a network", "give an ONNX or TorchScript file");
  }
}

}  // namespace

nlohmann::json ModelFile::about() const { return parse_json(description, file.string(), "pliant"); }

std::string ModelFile::kind() const {
  const nlohmann::json about = this->about();
  return about.is_object() && about.contains("kind") && about["kind"].is_string() ? about["kind"].get<std::string>()
                                                                                  : "";
}

int ModelFile::size_of(const std::string& key, int otherwise) const {
  const nlohmann::json about = this->about();
  if (!about.is_object() || !about.contains(key)) return otherwise;
  const nlohmann::json& value = about[key];
  if (!value.is_number_integer() || value < 1 || value > 4096)
    throw input_error(file.string(), "pliant." + key, "is " + value.dump(), "export the model again");
  return value;
}

ModelFile read_model_file(const std::filesystem::path& file) {
  ModelFile model;
  model.file = file;
  std::string magic(4, '\0');
  std::ifstream in(file, std::ios::binary);
  if (!in) throw input_error(file.string(), "", "cannot be read", "give an ONNX or TorchScript file");
  in.read(magic.data(), 4);
  if (magic == std::string("PK\x03\x04")) {
    read_torch_script(file, model);
    model.sha256 = sha256_of_file(file);
    return model;
  }
  const std::string bytes = read_text(file);
  model.graph = read_onnx(bytes, file.string());
  model.sha256 = sha256_of_text(bytes);
  if (const auto entry = model.graph.metadata.find("pliant"); entry != model.graph.metadata.end())
    model.description = entry->second;
  return model;
}

}  // namespace pliant
