#pragma once

#include <filesystem>
#include <string>
#include <unordered_map>
#include <vector>

namespace pliant {

/// Words of a text as "BERT uncased" splits them (Devlin et al. 2019, BasicTokenizer): control characters go, letters
/// become small and lose their accents, every punctuation mark and every Chinese character is a word of its own.
std::vector<std::string> basic_tokens(const std::string& text);

/// WordPiece (Wu et al. 2016) over the vocabulary file of a BERT, one piece per line, whose number is its id.
class WordPiece {
 public:
  /// Throws Error{kInput} when the file lacks [UNK], [CLS] or [SEP].
  explicit WordPiece(const std::filesystem::path& vocabulary);

  /// Longest pieces from the left, the later ones with "##"; a word with no such split, or of more than 100 letters, is
  /// [UNK].
  std::vector<std::string> tokenize(const std::string& text) const;
  /// [CLS], the pieces of the text, [SEP].
  std::vector<int64_t> encode(const std::string& text) const;

  int64_t id(const std::string& piece) const;  ///< that of [UNK] where it is unknown
  size_t size() const { return ids_.size(); }

 private:
  std::unordered_map<std::string, int64_t> ids_;
};

}  // namespace pliant
