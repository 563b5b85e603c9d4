#include "app/import/state_dict.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>

#include "app/import/pickle.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/zip_archive.h"

namespace pliant {
namespace {

using Kind = PickleValue::Kind;
constexpr uint64_t kMostPickle = 64ull << 20;  // bytes

struct StorageType {
  const char* name;
  size_t bytes;
};
// Types whose values become float; others may occur in a state dict and are passed over.
constexpr StorageType kFloating[] = {
    {"torch FloatStorage", 4}, {"torch DoubleStorage", 8}, {"torch HalfStorage", 2}, {"torch BFloat16Storage", 2}};
const char* const kOther[] = {"torch LongStorage", "torch IntStorage",  "torch ShortStorage",
                              "torch CharStorage", "torch ByteStorage", "torch BoolStorage"};

std::vector<std::string> allowed_globals() {
  std::vector<std::string> names = {"collections OrderedDict", "torch._utils _rebuild_tensor_v2",
                                    "torch._utils _rebuild_parameter"};
  for (const StorageType& type : kFloating) names.push_back(type.name);
  for (const char* name : kOther) names.push_back(name);
  return names;
}

float half_to_float(uint16_t bits) {
  const int exponent = bits >> 10 & 31, mantissa = bits & 1023;
  const float size = exponent == 0   ? std::ldexp(static_cast<float>(mantissa), -24)
                     : exponent < 31 ? std::ldexp(static_cast<float>(mantissa + 1024), exponent - 25)
                     : mantissa      ? NAN
                                     : INFINITY;
  return bits >> 15 ? -size : size;
}

template <class T>
T value_at(const std::string& bytes, size_t index) {
  T value;
  std::memcpy(&value, bytes.data() + index * sizeof(T), sizeof value);
  return value;
}

float float_at(const std::string& bytes, const std::string& type, size_t index) {
  if (type == "torch FloatStorage") return value_at<float>(bytes, index);
  if (type == "torch DoubleStorage") return static_cast<float>(value_at<double>(bytes, index));
  if (type == "torch HalfStorage") return half_to_float(value_at<uint16_t>(bytes, index));
  const uint32_t high = static_cast<uint32_t>(value_at<uint16_t>(bytes, index)) << 16;
  float value;
  std::memcpy(&value, &high, sizeof value);
  return value;
}

/// Reads the tensors that a parsed pickle describes out of its archive.
class TensorReader {
 public:
  TensorReader(const Pickle& pickle, ZipArchive& zip, std::string folder, std::string file)
      : pickle_(pickle), zip_(zip), folder_(std::move(folder)), file_(std::move(file)) {}

  /// False for a value that is no tensor of floating-point numbers.
  bool read(const std::string& name, int value, StateTensor& tensor) {
    const PickleValue* object = &pickle_[value];
    if (object->kind != Kind::kObject) return false;
    const std::string& callable = pickle_[object->items[0]].text;
    const std::vector<int>& arguments = pickle_[object->items[1]].items;
    if (callable == "torch._utils _rebuild_parameter") {
      // A parameter wraps a tensor; a parameter inside a parameter is not a thing that torch writes.
      if (arguments.empty() || is_parameter(arguments[0])) throw refuse(name, "is a parameter without a tensor");
      return read(name, arguments[0], tensor);
    }
    if (arguments.size() < 4) throw refuse(name, "lacks arguments of a tensor");
    const PickleValue& storage = pickle_[arguments[0]];
    if (storage.kind != Kind::kPersistent) throw refuse(name, "has no storage");
    const PickleValue& id = pickle_[storage.items[0]];  // ("storage", type, key, device, count)
    if (id.kind != Kind::kTuple || id.items.size() < 5 || pickle_[id.items[1]].kind != Kind::kGlobal ||
        pickle_[id.items[2]].kind != Kind::kText)
      throw refuse(name, "has a storage of an unknown kind");
    const std::string& type = pickle_[id.items[1]].text;
    const auto known =
        std::find_if(std::begin(kFloating), std::end(kFloating), [&](const StorageType& t) { return type == t.name; });
    if (known == std::end(kFloating)) return false;

    const int64_t count = whole(name, id.items[4]), offset = whole(name, arguments[1]);
    const std::vector<int64_t> shape = wholes(name, arguments[2]), stride = wholes(name, arguments[3]);
    if (shape.size() != stride.size() || shape.size() > 8)
      throw refuse(name, "has " + std::to_string(shape.size()) + " dimensions");
    // The last element must lie in the storage, and no element may be there twice.
    uint64_t elements = 1, last = static_cast<uint64_t>(offset);
    for (size_t k = 0; k < shape.size(); ++k) {
      elements = shape[k] && elements > static_cast<uint64_t>(count) / static_cast<uint64_t>(shape[k])
                     ? ~0ull
                     : elements * static_cast<uint64_t>(shape[k]);
      if (elements > static_cast<uint64_t>(count))
        throw refuse(name, "has more elements than its storage, " + std::to_string(count));
      if (shape[k] > 0 && static_cast<uint64_t>(stride[k]) > static_cast<uint64_t>(count))
        throw refuse(name, "has a stride beyond its storage");
      if (shape[k] > 0) last += static_cast<uint64_t>(shape[k] - 1) * static_cast<uint64_t>(stride[k]);
    }
    if (elements > 0 && last >= static_cast<uint64_t>(count))
      throw refuse(name, "reaches beyond the end of its storage");

    const std::string bytes =
        storage_bytes(name, pickle_[id.items[2]].text, static_cast<uint64_t>(count) * known->bytes);
    tensor.shape = shape;
    tensor.data.resize(elements);
    std::vector<int64_t> index(shape.size(), 0);
    for (uint64_t i = 0; i < elements; ++i) {
      int64_t at = offset;
      for (size_t k = 0; k < shape.size(); ++k) at += index[k] * stride[k];
      tensor.data[i] = float_at(bytes, type, static_cast<size_t>(at));
      for (size_t k = shape.size(); k-- > 0 && ++index[k] == shape[k];) index[k] = 0;
    }
    return true;
  }

 private:
  Error refuse(const std::string& name, const std::string& problem) const {
    return input_error(file_, name, problem, "the file is damaged; save the state dict again");
  }
  bool is_parameter(int value) const {
    return pickle_[value].kind == Kind::kObject &&
           pickle_[pickle_[value].items[0]].text == "torch._utils _rebuild_parameter";
  }
  int64_t whole(const std::string& name, int value) const {
    const PickleValue& number = pickle_[value];
    if (number.kind != Kind::kInt || number.number < 0 || number.number > (1ll << 31))
      throw refuse(name, "has an impossible count");
    return number.number;
  }
  std::vector<int64_t> wholes(const std::string& name, int value) const {
    if (pickle_[value].kind != Kind::kTuple) throw refuse(name, "has no list of sizes");
    std::vector<int64_t> out;
    for (int item : pickle_[value].items) out.push_back(whole(name, item));
    return out;
  }
  std::string storage_bytes(const std::string& name, const std::string& key, uint64_t size) {
    if (key.empty() || key.size() > 20 || key.find_first_not_of("0123456789") != std::string::npos)
      throw refuse(name, "has the storage key '" + key + "'");
    const auto [at, fresh] = storages_.try_emplace(key);
    if (fresh) at->second = zip_.read(folder_ + "data/" + key, size);
    if (at->second.size() != size)
      throw refuse(name, "has a storage of " + std::to_string(at->second.size()) + " bytes, " + std::to_string(size) +
                             " are declared");
    return at->second;
  }

  const Pickle& pickle_;
  ZipArchive& zip_;
  std::string folder_, file_;
  std::map<std::string, std::string> storages_;
};

/// Says in which older or other format a file is that is no zip archive of a state dict.
void refuse_other_formats(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw input_error(file.string(), "", "cannot be read", "check the name");
  std::string head(16, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<size_t>(in.gcount()));
  const std::string magic("\x8a\x0a\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19", 12);
  if (head.find(magic) != std::string::npos)
    throw input_error(file.string(), "", "is in PyTorch's format from before version 1.6",
                      "load it and save it again: torch.save(torch.load(FILE), FILE)");
  if (head.rfind("PK", 0) != 0)
    throw input_error(file.string(), "", "is not a state dict: it is not a zip archive",
                      "save it with torch.save(model.state_dict(), FILE)");
}

}  // namespace

std::map<std::string, StateTensor> read_state_dict(const std::filesystem::path& file) {
  refuse_other_formats(file);
  ZipArchive zip(file);
  std::string folder;
  bool found = false, script = false;
  for (const std::string& name : zip.names()) {
    if (name.size() >= 8 && name.compare(name.size() - 8, 8, "data.pkl") == 0 &&
        (name.size() == 8 || name[name.size() - 9] == '/')) {
      folder = name.substr(0, name.size() - 8);
      found = true;
    }
    script = script || name.find("constants.pkl") != std::string::npos;
  }
  if (script)
    throw input_error(file.string(), "", "is a TorchScript module",
                      "save the state dict: torch.save(model.state_dict(), FILE)");
  if (!found)
    throw input_error(file.string(), "data.pkl", "is missing in the archive",
                      "save it with torch.save(model.state_dict(), FILE)");
  for (const std::string& name : zip.names())
    if (name == folder + "byteorder" && zip.read(name, 16) != "little")
      throw input_error(file.string(), "byteorder", "is not little", "save it on a machine with little-endian numbers");

  const std::string bytes = zip.read(folder + "data.pkl", kMostPickle);
  const Pickle pickle = parse_pickle(bytes, allowed_globals(), file.string(), "data.pkl");
  const PickleValue& root = pickle[pickle.root];
  if (root.kind != Kind::kDict)
    throw input_error(file.string(), "data.pkl", "is not a dict of tensors",
                      "save the state dict: torch.save(model.state_dict(), FILE)");
  TensorReader reader(pickle, zip, folder, file.string());
  std::map<std::string, StateTensor> tensors;
  for (const auto& [key, value] : root.entries) {
    if (pickle[key].kind != Kind::kText) continue;
    StateTensor tensor;
    if (reader.read(pickle[key].text, value, tensor)) tensors[pickle[key].text] = std::move(tensor);
  }
  return tensors;
}

}  // namespace pliant
