#include "app/import/pickle.h"

#include <algorithm>
#include <map>

#include "gaussians/base/error.h"
#include "gaussians/io/files/byte_reader.h"

namespace pliant {
namespace {

using Kind = PickleValue::Kind;
constexpr size_t kMostValues = 10'000'000;

/// The stack machine of the pickle format, with the operations that state dicts use.
class Machine {
 public:
  Machine(std::string_view bytes, const std::vector<std::string>& allowed, const std::string& file,
          const std::string& entry)
      : in_(bytes, file), allowed_(allowed), entry_(entry) {}

  Pickle run() {
    while (step()) {
    }
    return std::move(out_);
  }

 private:
  static constexpr int kMark = -1;

  Error refuse(const std::string& problem) const {
    return input_error(in_.file(), entry_, problem,
                       "only a state dict, as torch.save(model.state_dict(), FILE) writes it, is read");
  }

  void push(PickleValue value) {
    if (out_.values.size() >= kMostValues) throw refuse("has more than " + std::to_string(kMostValues) + " values");
    stack_.push_back(static_cast<int>(out_.values.size()));
    out_.values.push_back(std::move(value));
  }
  void push(Kind kind) { push(PickleValue{kind, 0, 0, {}, {}, {}}); }
  void push_int(int64_t number) { push(PickleValue{Kind::kInt, number, 0, {}, {}, {}}); }

  int pop() {
    if (stack_.empty() || stack_.back() == kMark) throw refuse("pops a value from an empty stack");
    const int value = stack_.back();
    stack_.pop_back();
    return value;
  }
  /// Values above the last mark, which goes too.
  std::vector<int> pop_to_mark() {
    size_t mark = stack_.size();
    while (mark > 0 && stack_[mark - 1] != kMark) --mark;
    if (mark == 0) throw refuse("lacks a mark");
    std::vector<int> items(stack_.begin() + static_cast<std::ptrdiff_t>(mark), stack_.end());
    stack_.resize(mark - 1);
    return items;
  }
  PickleValue& top(Kind kind) {
    if (stack_.empty() || stack_.back() == kMark) throw refuse("pops a value from an empty stack");
    PickleValue& value = out_.values[stack_.back()];
    if (value.kind != kind) throw refuse("fills a value that is not a container of that kind");
    return value;
  }
  void add_entries(const std::vector<int>& items) {
    if (items.size() % 2) throw refuse("gives a key without a value");
    PickleValue& dict = top(Kind::kDict);
    for (size_t k = 0; k < items.size(); k += 2) dict.entries.emplace_back(items[k], items[k + 1]);
  }
  void push_tuple(std::vector<int> items) { push(PickleValue{Kind::kTuple, 0, 0, {}, std::move(items), {}}); }
  void push_tuple(size_t count) {
    std::vector<int> items(count);
    for (size_t k = count; k-- > 0;) items[k] = pop();
    push_tuple(std::move(items));
  }
  std::string line() {
    std::string text;
    for (char c = in_.take<char>(entry_); c != '\n'; c = in_.take<char>(entry_)) {
      text += c;
      if (text.size() > 200) throw refuse("has a name of more than 200 letters");
    }
    return text;
  }
  void push_global() {
    const std::string module = line(), name = module + " " + line();
    if (!std::count(allowed_.begin(), allowed_.end(), name)) {
      std::string dotted = name;
      std::replace(dotted.begin(), dotted.end(), ' ', '.');
      throw refuse("names '" + dotted + "', which no state dict needs: loading it in Python could run a program");
    }
    push(PickleValue{Kind::kGlobal, 0, 0, name, {}, {}});
  }
  /// An OrderedDict is a dict; its attributes are of no interest.
  void reduce() {
    const int arguments = pop(), callable = pop();
    if (out_[callable].kind != Kind::kGlobal || out_[arguments].kind != Kind::kTuple)
      throw refuse("calls an object without a name");
    if (out_[callable].text == "collections OrderedDict") {
      if (!out_[arguments].items.empty()) throw refuse("makes an OrderedDict in an unknown way");
      push(Kind::kDict);
    } else {
      push(PickleValue{Kind::kObject, 0, 0, {}, {callable, arguments}, {}});
    }
  }
  void build() {
    pop();
    top(Kind::kDict);
  }
  int64_t long_number() {
    const std::string_view bytes = in_.take_bytes(in_.take<uint8_t>(entry_), entry_);
    if (bytes.size() > 8) throw refuse("holds a number of more than 64 bits");
    uint64_t number = bytes.empty() || static_cast<int8_t>(bytes.back()) >= 0 ? 0 : ~0ull;
    for (size_t k = bytes.size(); k-- > 0;) number = number << 8 | static_cast<uint8_t>(bytes[k]);
    return static_cast<int64_t>(number);
  }
  void put(uint32_t key) {
    if (stack_.empty() || stack_.back() == kMark) throw refuse("memoizes a value from an empty stack");
    memo_[key] = stack_.back();
  }
  void get(uint32_t key) {
    const auto found = memo_.find(key);
    if (found == memo_.end()) throw refuse("recalls a value that was never memoized");
    stack_.push_back(found->second);
  }

  /// One operation; false after the last one.
  bool step() {
    const uint8_t op = in_.take<uint8_t>(entry_);
    switch (op) {
      case 0x80:  // PROTO
        if (const int protocol = in_.take<uint8_t>(entry_); protocol != 2)
          throw refuse("is of pickle protocol " + std::to_string(protocol) + ", 2 is expected");
        return true;
      case '(':
        return stack_.push_back(kMark), true;
      case ')':
        return push_tuple(std::vector<int>()), true;
      case '}':
        return push(Kind::kDict), true;
      case ']':
        return push(Kind::kList), true;
      case 'N':
        return push(Kind::kNone), true;
      case 0x88:
        return push(PickleValue{Kind::kBool, 1, 0, {}, {}, {}}), true;
      case 0x89:
        return push(PickleValue{Kind::kBool, 0, 0, {}, {}, {}}), true;
      case 'K':
        return push_int(in_.take<uint8_t>(entry_)), true;
      case 'M':
        return push_int(in_.take<uint16_t>(entry_)), true;
      case 'J':
        return push_int(in_.take<int32_t>(entry_)), true;
      case 0x8a:
        return push_int(long_number()), true;
      case 'G': {  // BINFLOAT, big endian
        uint64_t bits = 0;
        for (char c : in_.take_bytes(8, entry_)) bits = bits << 8 | static_cast<uint8_t>(c);
        double real;
        std::memcpy(&real, &bits, sizeof real);
        return push(PickleValue{Kind::kFloat, 0, real, {}, {}, {}}), true;
      }
      case 'X': {  // BINUNICODE
        const uint32_t length = in_.take<uint32_t>(entry_);
        return push(PickleValue{Kind::kText, 0, 0, std::string(in_.take_bytes(length, entry_)), {}, {}}), true;
      }
      case 'c':
        return push_global(), true;
      case 'q':
        return put(in_.take<uint8_t>(entry_)), true;
      case 'r':
        return put(in_.take<uint32_t>(entry_)), true;
      case 'h':
        return get(in_.take<uint8_t>(entry_)), true;
      case 'j':
        return get(in_.take<uint32_t>(entry_)), true;
      case 't':
        return push_tuple(pop_to_mark()), true;
      case 0x85:
        return push_tuple(1), true;
      case 0x86:
        return push_tuple(2), true;
      case 0x87:
        return push_tuple(3), true;
      case 'Q': {
        const int id = pop();
        return push(PickleValue{Kind::kPersistent, 0, 0, {}, {id}, {}}), true;
      }
      case 'R':
        return reduce(), true;
      case 'b':
        return build(), true;
      case 's': {
        const int value = pop(), key = pop();
        return add_entries({key, value}), true;
      }
      case 'u':
        return add_entries(pop_to_mark()), true;
      case 'a': {
        const int value = pop();
        return top(Kind::kList).items.push_back(value), true;
      }
      case 'e': {
        const std::vector<int> items = pop_to_mark();
        PickleValue& list = top(Kind::kList);
        return list.items.insert(list.items.end(), items.begin(), items.end()), true;
      }
      case '.':
        out_.root = pop();
        return false;
      default:
        throw refuse("holds the operation " + std::to_string(op) + ", which no state dict needs");
    }
  }

  ByteReader in_;
  const std::vector<std::string>& allowed_;
  std::string entry_;
  Pickle out_;
  std::vector<int> stack_;
  std::map<uint32_t, int> memo_;
};

}  // namespace

Pickle parse_pickle(std::string_view bytes, const std::vector<std::string>& allowed, const std::string& file,
                    const std::string& entry) {
  return Machine(bytes, allowed, file, entry).run();
}

}  // namespace pliant
