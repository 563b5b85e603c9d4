#include "fitting/predict/label_words.h"

#include <map>

namespace pliant {
namespace {

constexpr size_t kMaxCharacters = 256, kMaxWords = 32;

bool is_letter_or_digit(char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); }

std::string singular(const std::string& word) {
  static const std::map<std::string, std::string> irregular = {{"leaves", "leaf"},
                                                               {"loaves", "loaf"},
                                                               {"knives", "knife"},
                                                               {"shelves", "shelf"},
                                                               {"halves", "half"},
                                                               {"scarves", "scarf"},
                                                               {"wolves", "wolf"},
                                                               {"shoes", "shoe"},
                                                               {"toes", "toe"},
                                                               {"canoes", "canoe"},
                                                               {"buses", "bus"},
                                                               {"cookies", "cookie"},
                                                               {"skis", "ski"},
                                                               {"men", "man"},
                                                               {"women", "woman"},
                                                               {"children", "child"},
                                                               {"geese", "goose"},
                                                               {"feet", "foot"},
                                                               {"teeth", "tooth"},
                                                               {"mice", "mouse"},
                                                               {"plushies", "plushie"},
                                                               {"hoodies", "hoodie"},
                                                               {"beanies", "beanie"},
                                                               {"brownies", "brownie"},
                                                               {"neckties", "necktie"},
                                                               {"movies", "movie"},
                                                               {"zombies", "zombie"},
                                                               {"barbies", "barbie"},
                                                               {"bookshelves", "bookshelf"},
                                                               {"calves", "calf"},
                                                               {"hooves", "hoof"},
                                                               {"snowmen", "snowman"},
                                                               {"irises", "iris"},
                                                               {"aloes", "aloe"},
                                                               {"mousses", "mousse"},
                                                               {"kiwis", "kiwi"},
                                                               {"bonsais", "bonsai"},
                                                               {"tvs", "tv"},
                                                               {"pcs", "pc"},
                                                               {"canvas", "canvas"},
                                                               {"canvases", "canvas"},
                                                               {"rhinoceros", "rhinoceros"},
                                                               {"rhinoceroses", "rhinoceros"}};
  const auto found = irregular.find(word);
  if (found != irregular.end()) return found->second;
  const auto without = [&](size_t n) { return word.substr(0, word.size() - n); };
  if (word.size() > 4) {
    if (word.ends_with("ies")) return without(3) + "y";
    for (const char* ending : {"sses", "xes", "ches", "shes", "oes"})
      if (word.ends_with(ending)) return without(2);
    if (word.size() > 6 && word.ends_with("uses") && !word.ends_with("ouses")) return without(2);
  }
  const bool keeps = word.ends_with("ss") || word.ends_with("us") || word.ends_with("is");
  return word.size() > 3 && word.ends_with('s') && !keeps ? without(1) : word;
}

}  // namespace

std::vector<LabelWord> label_words(std::string_view text) {
  std::vector<LabelWord> words;
  std::string word;
  bool after_break = false;
  const auto finish = [&] {
    if (!word.empty() && word != "a" && word != "an" && word != "the") {
      words.push_back({singular(word), after_break});
      after_break = false;
    }
    word.clear();
  };
  for (const char raw : text.substr(0, kMaxCharacters)) {
    const char c = raw >= 'A' && raw <= 'Z' ? static_cast<char>(raw - 'A' + 'a') : raw;
    if (is_letter_or_digit(c)) {
      word += c;
    } else if (c != '\'') {
      finish();
      after_break |= std::string_view(",;:.()[]{}/|\n").find(c) != std::string_view::npos;
    }
    if (words.size() == kMaxWords) return words;
  }
  finish();
  return words;
}

std::string label_key(std::string_view text) {
  std::string key;
  for (const LabelWord& word : label_words(text)) key += (key.empty() ? "" : " ") + word.word;
  return key;
}

}  // namespace pliant
