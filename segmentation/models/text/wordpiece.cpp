#include "segmentation/models/text/wordpiece.h"

#include <sstream>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "segmentation/models/text/unicode.h"

namespace pliant {
namespace {

/// The blocks that BERT calls Chinese: unified and compatibility ideographs.
bool is_ideograph(char32_t c) {
  return (c >= 0x4e00 && c <= 0x9fff) || (c >= 0x3400 && c <= 0x4dbf) || (c >= 0x20000 && c <= 0x2a6df) ||
         (c >= 0x2a700 && c <= 0x2ceaf) || (c >= 0xf900 && c <= 0xfaff) || (c >= 0x2f800 && c <= 0x2fa1f);
}

/// Hangul syllables fall apart into their letters (Unicode 3.12).
void append_plain(std::u32string& word, char32_t c) {
  if (c < 0xac00 || c > 0xd7a3) {
    word += plain_letter(c);
    return;
  }
  const char32_t index = c - 0xac00;
  word += 0x1100 + index / 588;
  word += 0x1161 + index % 588 / 28;
  if (index % 28) word += 0x11a7 + index % 28;
}

}  // namespace

std::vector<std::string> basic_tokens(const std::string& text) {
  std::vector<std::string> tokens;
  std::u32string word;
  const auto end_word = [&] {
    if (!word.empty()) tokens.push_back(to_utf8(word));
    word.clear();
  };
  for (const char32_t c : to_code_points(text)) {
    if (is_control(c) || is_mark(c)) continue;
    if (is_space(c)) {
      end_word();
    } else if (is_punctuation(c) || is_ideograph(c)) {
      end_word();
      word = c;
      end_word();
    } else {
      append_plain(word, c);
    }
  }
  end_word();
  return tokens;
}

WordPiece::WordPiece(const std::filesystem::path& vocabulary) {
  std::istringstream lines(read_text(vocabulary));
  int64_t number = 0;
  for (std::string line; std::getline(lines, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    ids_.emplace(line, number);
  }
  for (const char* piece : {"[UNK]", "[CLS]", "[SEP]"})
    if (!ids_.count(piece))
      throw input_error(vocabulary.string(), piece, "is not in it",
                        "give the vocab.txt of the text encoder, one piece per line");
}

std::vector<std::string> WordPiece::tokenize(const std::string& text) const {
  std::vector<std::string> pieces;
  for (const std::string& word : basic_tokens(text)) {
    const std::u32string letters = to_code_points(word);
    std::vector<std::string> of_word;
    size_t begin = 0;
    while (begin < letters.size() && letters.size() <= 100) {
      size_t length = letters.size() - begin;
      std::string piece;
      for (; length > 0; --length) {
        piece = (begin ? "##" : "") + to_utf8(letters.substr(begin, length));
        if (ids_.count(piece)) break;
      }
      if (length == 0) break;
      of_word.push_back(std::move(piece));
      begin += length;
    }
    if (begin < letters.size()) of_word = {"[UNK]"};
    pieces.insert(pieces.end(), of_word.begin(), of_word.end());
  }
  return pieces;
}

std::vector<int64_t> WordPiece::encode(const std::string& text) const {
  std::vector<int64_t> ids = {id("[CLS]")};
  for (const std::string& piece : tokenize(text)) ids.push_back(id(piece));
  ids.push_back(id("[SEP]"));
  return ids;
}

int64_t WordPiece::id(const std::string& piece) const {
  const auto found = ids_.find(piece);
  return found == ids_.end() ? ids_.at("[UNK]") : found->second;
}

}  // namespace pliant
