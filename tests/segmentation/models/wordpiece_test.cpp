#include "segmentation/models/text/wordpiece.h"

#include <gtest/gtest.h>

#include <map>

#include "segmentation/models/text/unicode.h"
#include "tests/temporary_folder.h"

using namespace pliant;

namespace {

using Words = std::vector<std::string>;

std::string lines(const Words& words) {
  std::string text;
  for (const std::string& word : words) text += word + "\n";
  return text;
}

/// The lines of bert-base-uncased's vocab.txt that the examples need, at their numbers.
std::string part_of_bert_vocabulary() {
  const std::map<int, std::string> known = {
      {0, "[PAD]"},   {100, "[UNK]"},   {101, "[CLS]"},  {102, "[SEP]"},    {999, "!"},        {1005, "'"},
      {1010, ","},    {1012, "."},      {1037, "a"},     {1045, "i"},       {2003, "is"},      {2005, "for"},
      {2023, "this"}, {2026, "my"},     {2042, "been"},  {2061, "so"},      {2166, "life"},    {2172, "much"},
      {2310, "ve"},   {2607, "course"}, {2878, "whole"}, {3403, "waiting"}, {3899, "dog"},     {4937, "cat"},
      {5223, "hate"}, {7592, "hello"},  {10140, "cute"}, {12172, "##face"}, {17662, "hugging"}};
  Words all;
  for (int i = 0; i <= 17662; ++i) all.push_back(known.count(i) ? known.at(i) : "[unused" + std::to_string(i) + "]");
  return lines(all);
}

}  // namespace

// The first four are those of google-research/bert, tokenization_test.py.
TEST(WordPiece, PublishedExampleOfTheFullTokenizer) {
  TemporaryFolder folder;
  const WordPiece tokenizer(folder.file(
      "vocab.txt", lines({"[UNK]", "[CLS]", "[SEP]", "want", "##want", "##ed", "wa", "un", "runn", "##ing", ","})));
  const Words pieces = tokenizer.tokenize("UNwant\u00E9d,running");
  EXPECT_EQ(pieces, (Words{"un", "##want", "##ed", ",", "runn", "##ing"}));
  std::vector<int64_t> ids;
  for (const std::string& piece : pieces) ids.push_back(tokenizer.id(piece));
  EXPECT_EQ(ids, (std::vector<int64_t>{7, 4, 5, 10, 8, 9}));
}

TEST(WordPiece, PublishedExamplesOfUnknownWords) {
  TemporaryFolder folder;
  const WordPiece tokenizer(folder.file(
      "vocab.txt", lines({"[UNK]", "[CLS]", "[SEP]", "want", "##want", "##ed", "wa", "un", "runn", "##ing"})));
  EXPECT_TRUE(tokenizer.tokenize("").empty());
  EXPECT_EQ(tokenizer.tokenize("unwanted running"), (Words{"un", "##want", "##ed", "runn", "##ing"}));
  EXPECT_EQ(tokenizer.tokenize("unwantedX running"), (Words{"[UNK]", "runn", "##ing"}));
}

TEST(WordPiece, PublishedExampleOfChinese) {
  EXPECT_EQ(basic_tokens("ah\u535A\u63A8zz"), (Words{"ah", "\u535A", "\u63A8", "zz"}));
}

TEST(WordPiece, PublishedExamplesOfSmallLettersAndAccents) {
  EXPECT_EQ(basic_tokens(" \tHeLLo!how  \n Are yoU?  "), (Words{"hello", "!", "how", "are", "you", "?"}));
  EXPECT_EQ(basic_tokens("H\u00E9llo"), (Words{"hello"}));
}

// Ids printed in the documentation of Hugging Face transformers (BertModel; course, chapters 2.1 and 2.2).
TEST(WordPiece, PublishedIdsOfBertBaseUncased) {
  TemporaryFolder folder;
  const WordPiece tokenizer(folder.file("vocab.txt", part_of_bert_vocabulary()));
  EXPECT_EQ(tokenizer.encode("Hello, my dog is cute"),
            (std::vector<int64_t>{101, 7592, 1010, 2026, 3899, 2003, 10140, 102}));
  EXPECT_EQ(tokenizer.encode("I've been waiting for a HuggingFace course my whole life."),
            (std::vector<int64_t>{101, 1045, 1005, 2310, 2042, 3403, 2005, 1037, 17662, 12172, 2607, 2026, 2878, 2166,
                                  1012, 102}));
  EXPECT_EQ(tokenizer.encode("I hate this so much!"),
            (std::vector<int64_t>{101, 1045, 5223, 2023, 2061, 2172, 999, 102}));
}

TEST(WordPiece, AccentsGoWhetherWrittenApartOrTogether) {
  EXPECT_EQ(basic_tokens("e\u0301te\u0301"), basic_tokens("\u00E9t\u00E9"));
  EXPECT_EQ(basic_tokens("\u00C5NGSTR\u00D6M \u1E9E\u0130 \u0391\u0386\u03A9 \u0419 \u304C"),
            (Words{"angstrom", "\u00DFi", "\u03B1\u03B1\u03C9", "\u0438", "\u304B"}));
  EXPECT_EQ(basic_tokens("\uD55C"), (Words{"\u1112\u1161\u11AB"}));
}

TEST(WordPiece, PunctuationOfAnyScriptStandsAlone) {
  EXPECT_EQ(basic_tokens("a.b\u2014c\u3002d\u00BFe$f^g"),
            (Words{"a", ".", "b", "\u2014", "c", "\u3002", "d", "\u00BF", "e", "$", "f", "^", "g"}));
}

TEST(WordPiece, ControlCharactersVanishAndSpacesOfAllKindsPart) {
  EXPECT_EQ(basic_tokens("so\u00ADft\u200Bly\u00A0now\u3000then\xff!"), (Words{"softly", "now", "then", "!"}));
}

TEST(WordPiece, AVocabularyWithoutTheSpecialPiecesIsRefused) {
  TemporaryFolder folder;
  const auto file = folder.file("tags.txt", "chair\ntable\n");
  expect_error(Failure::kInput, {"tags.txt", "[UNK]"}, [&] { WordPiece tokenizer(file); });
}

TEST(Unicode, Utf8SurvivesARoundTrip) {
  std::u32string text;
  for (char32_t c = 1; c < 0x110000; c += c < 0x900 ? 1 : 257)
    if (c < 0xd800 || c > 0xdfff) text += c;
  EXPECT_TRUE(to_code_points(to_utf8(text)) == text);
}
