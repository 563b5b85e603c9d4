#include "fitting/predict/label_match.h"

#include <algorithm>
#include <map>
#include <set>

#include "fitting/predict/label_words.h"

namespace pliant {
namespace {

constexpr size_t kNone = static_cast<size_t>(-1);

const std::set<std::string> kLinks = {"with", "in",      "on",     "of",      "from",   "at",  "by",   "near", "under",
                                      "over", "beside",  "behind", "without", "for",    "and", "or",   "that", "which",
                                      "to",   "holding", "inside", "against", "around", "has", "made", "out"};
/// Words that say nothing about the material.
const std::set<std::string> kPlain = {
    "small",   "big",    "large", "little", "tiny",   "tall",    "short",    "long",  "old",       "new",   "young",
    "nice",    "red",    "green", "blue",   "yellow", "pink",    "white",    "black", "brown",     "grey",  "gray",
    "purple",  "violet", "dark",  "light",  "bright", "hanging", "standing", "lying", "beautiful", "round", "empty",
    "full",    "thin",   "thick", "soft",   "hard",   "fresh",   "pair",     "bunch", "piece",     "close", "photo",
    "picture", "single", "one",   "two",    "three",  "several", "some",     "real",  "my",        "this"};

/// Materials that are colors as well.
const std::set<std::string> kColours = {"gold", "silver", "copper", "coral", "ivory"};
constexpr double kSmall = 0.8;  // m, height below which things are of precious metal
/// Objects by the word that says so before an animal or a figure.
const std::map<std::string, std::string> kToys = {
    {"plush", "plush toy"},  {"plushie", "plush toy"}, {"stuffed", "plush toy"},
    {"cuddly", "plush toy"}, {"soft", "plush toy"},    {"inflatable", "beach ball"},
    {"balloon", "balloon"},  {"origami", "origami"},   {"robot", "toy robot"}};

/// A phrase of the label that stands in the table.
struct Hit {
  size_t begin = 0, end = 0;  ///< words
  size_t material = kNone, object = kNone;
  int segment = 0;   ///< counted by commas and by words such as "with"
  std::string link;  ///< word that the segment begins with; "," after a comma; empty for the first
};

std::string joined(const std::vector<LabelWord>& words, size_t begin, size_t end) {
  std::string out;
  for (size_t i = begin; i < end; ++i) out += (i > begin ? " " : "") + words[i].word;
  return out;
}

/// The longest phrase that begins at a word; no words when there is none.
Hit longest_hit(const MaterialTable& table, const std::vector<LabelWord>& words, size_t begin) {
  size_t end = std::min(words.size(), begin + table.longest_name);
  for (size_t i = begin + 1; i < end; ++i)
    if (words[i].after_break) end = i;
  for (; end > begin; --end) {
    const std::string key = joined(words, begin, end);
    const auto material = table.material_of.find(key);
    const auto object = table.object_of.find(key);
    Hit hit;
    hit.begin = begin;
    hit.end = end;
    if (material != table.material_of.end()) hit.material = material->second;
    if (object != table.object_of.end()) hit.object = object->second;
    if (hit.material != kNone || hit.object != kNone) return hit;
  }
  return {};
}

std::vector<Hit> hits_of(const MaterialTable& table, const std::vector<LabelWord>& words, size_t& telling) {
  std::vector<Hit> hits;
  int segment = 0;
  std::string link;
  for (size_t i = 0; i < words.size();) {
    if (words[i].after_break) {
      ++segment;
      link = ",";
    }
    Hit hit = longest_hit(table, words, i);
    if (hit.end > i) {
      hit.segment = segment;
      hit.link = link;
      telling += hit.end - i;
      i = hit.end;
      hits.push_back(hit);
      continue;
    }
    if (kLinks.count(words[i].word)) {
      ++segment;
      link = words[i].word;
    } else if (!kPlain.count(words[i].word)) {
      ++telling;
    }
    ++i;
  }
  return hits;
}

bool one_of(const std::string& name, std::initializer_list<const char*> names) {
  return std::any_of(names.begin(), names.end(), [&](const char* other) { return name == other; });
}

/// Whether "X of material" and "material X" say what X is made of, not what it holds, cuts or cleans: a butter knife.
bool builds(const KnownMaterial& material) {
  if (one_of(material.name, {"bamboo", "straw", "cork"})) return true;
  if (one_of(material.name, {"ice", "soap", "plasticine", "dough", "whipped cream"})) return false;
  return !one_of(material.group, {"food", "plant", "tissue", "liquid", "granular", "gel"});
}
/// Whether a figure of such a material is called by what it shows: a bronze rose.
bool carves(const std::string& group) {
  return one_of(group, {"wood", "metal", "stone", "ceramic", "glass", "plastic", "rubber", "mineral", "wax", "paper"});
}
/// Whether a figure is made of it: a chocolate statue, an ivory one, a snow sculpture.
bool forms_figures(const KnownMaterial& material) {
  if (one_of(material.name, {"bone", "horn"}) || builds(material)) return true;
  return !one_of(material.group, {"plant", "tissue", "liquid"});
}
/// Animals are shown in softer things too: a plush elephant, a chocolate bunny.
bool shows_animals(const std::string& group) {
  return carves(group) || one_of(group, {"textile", "leather", "foam", "food", "gel", "dough"});
}
bool covers(const std::string& group) { return one_of(group, {"textile", "leather"}); }
bool is_figure(const KnownObject& object) {
  return std::any_of(object.parts.begin(), object.parts.end(), [](auto& part) { return part.shows; });
}
bool is_tissue(const MatchedPart& part) { return part.material->group == "tissue"; }

size_t object_called(const MaterialTable& table, const std::string& name) {
  const auto found = table.object_of.find(label_key(name));
  return found == table.object_of.end() ? kNone : found->second;
}

/// The material that the label gives its head.
struct Given {
  const KnownMaterial* material = nullptr;  ///< null where it gives none
  std::string word;                         ///< for it
  bool stated = false;                      ///< with "of", as in "chair made of steel"
};

Given given_material(const MaterialTable& table, const std::vector<LabelWord>& words, const std::vector<Hit>& hits,
                     size_t head) {
  const auto given = [&](const Hit& hit, bool stated) {
    return Given{&table.materials[hit.material], joined(words, hit.begin, hit.end), stated};
  };
  const Hit* nearest = nullptr;
  for (size_t i = head; i-- > 0 && hits[i].segment == hits[head].segment;) {
    if (hits[i].material == kNone) continue;
    // Of a wooden butter knife the wood.
    if (builds(table.materials[hits[i].material])) return given(hits[i], false);
    if (!nearest) nearest = &hits[i];
  }
  if (nearest) return given(*nearest, false);
  const bool figure = is_figure(table.objects[hits[head].object]);
  for (size_t i = head + 1; i < hits.size(); ++i) {
    const Hit& hit = hits[i];
    const bool links = one_of(hit.link, {"of", "from", "made", ","});
    if (hit.segment == hits[head].segment || !links || hit.material == kNone) continue;
    const KnownMaterial& material = table.materials[hit.material];
    const bool formed = figure && hit.object == kNone && forms_figures(material);
    if (formed || builds(material)) return given(hit, hit.link != ",");
  }
  return {};
}

/// Whether a part that a label's material can replace is of it.
bool takes(const Given& given, const KnownObject& object, const KnownPart& part, const std::string& usual) {
  if (given.stated) return true;
  if (part.shows) return forms_figures(*given.material);
  const bool hard = one_of(usual, {"metal", "ceramic", "stone", "mineral"}) && object.height.typical < kSmall;
  return builds(*given.material) && (hard || !kColours.count(given.word));
}

/// Gives the object's parts the material that the label names.
void replace_material(const Given& given, PriorMatch& match) {
  const KnownMaterial& material = *given.material;
  const std::vector<KnownPart>& known = match.object->parts;
  std::vector<MatchedPart>& parts = match.parts;
  const bool some = std::any_of(known.begin(), known.end(), [](auto& part) { return part.replaceable; });
  const bool animal = !some && std::any_of(parts.begin(), parts.end(), is_tissue);
  const bool shown =
      given.stated || (animal ? shows_animals(material.group) : carves(material.group) && !kColours.count(given.word));
  bool changed = false;
  for (size_t i = 0; i < parts.size(); ++i) {
    const std::string& usual = parts[i].material->group;
    const bool fits = some ? known[i].replaceable && takes(given, *match.object, known[i], usual) : shown;
    // A leather sofa has a leather cover, not a leather frame.
    const bool cover = !given.stated && !animal && !known[i].shows && covers(material.group) && !covers(usual);
    if (!fits || cover) continue;
    parts[i].instead_of = parts[i].material;
    parts[i].material = &material;
    changed = true;
  }
  match.figure = animal && changed;
  if (!changed) match.unused = given.word;
}

/// The toy that a word before an animal or a figure says: a plush dinosaur, a balloon dog.
size_t toy_of(const MaterialTable& table, const std::vector<LabelWord>& words, const std::vector<Hit>& hits,
              size_t head) {
  const size_t begin = hits[head].begin;
  const std::vector<KnownPart>& parts = table.objects[hits[head].object].parts;
  const bool figure = is_figure(table.objects[hits[head].object]);
  const bool animal = std::any_of(parts.begin(), parts.end(), [&](auto& part) {
    return part.moves && table.materials[part.material].group == "tissue";
  });
  if (begin == 0 || words[begin].after_break || !(figure || animal)) return kNone;
  const std::string& word = words[begin - 1].word;
  const auto toy = kToys.find(word);
  // A soft rabbit may be alive.
  if (toy != kToys.end() && (figure || word != "soft")) return object_called(table, toy->second);
  const Hit* before = head > 0 && hits[head - 1].end == begin ? &hits[head - 1] : nullptr;
  if (!before || before->object == kNone) return kNone;
  for (const auto& [of, name] : kToys)
    if (table.objects[before->object].name == name) return before->object;
  return kNone;
}

/// What a label means by a vessel with plants, or by the head of a statue; else its head.
size_t meant_object(const MaterialTable& table, const std::vector<Hit>& hits, size_t head, const std::string& phrase) {
  const size_t usual = hits[head].object;
  const bool pot = phrase == "pot", vessel = pot || one_of(phrase, {"vase", "jug", "urn", "pitcher", "amphora"});
  const bool limb = one_of(table.objects[usual].name, {"hand", "head"});
  for (size_t i = head + 1; i < hits.size() && (vessel || limb); ++i) {
    if (hits[i].object == kNone || !one_of(hits[i].link, {"of", "with", "holding"})) continue;
    const std::vector<KnownPart>& parts = table.objects[hits[i].object].parts;
    const auto moves_as = [&](const char* group) {
      return std::all_of(parts.begin(), parts.end(),
                         [&](auto& part) { return !part.moves || table.materials[part.material].group == group; });
    };
    if (limb && hits[i].link == "of" && !moves_as("tissue")) return hits[i].object;
    if (!vessel || !moves_as("plant")) continue;
    const bool potted = std::any_of(parts.begin(), parts.end(), [](auto& part) { return part.replaceable; });
    const size_t filled = object_called(table, pot ? "potted plant" : "bouquet in a vase");
    return potted || filled == kNone ? hits[i].object : filled;
  }
  return usual;
}

}  // namespace

std::optional<PriorMatch> match_label(const MaterialTable& table, std::string_view label) {
  const std::vector<LabelWord> words = label_words(label);
  size_t telling = 0, understood = 0;
  const std::vector<Hit> hits = hits_of(table, words, telling);
  if (hits.empty()) return std::nullopt;
  for (const Hit& hit : hits) understood += hit.end - hit.begin;
  size_t head = 0;
  while (head + 1 < hits.size() && hits[head + 1].segment == hits[0].segment) ++head;

  PriorMatch out;
  if (hits[head].object == kNone) out = match_material(table.materials[hits[head].material]);
  out.phrase = joined(words, hits[head].begin, hits[head].end);
  out.certainty = static_cast<double>(understood) / static_cast<double>(telling);
  if (hits[head].object == kNone) return out;
  const size_t toy = toy_of(table, words, hits, head);
  out.object = &table.objects[toy != kNone ? toy : meant_object(table, hits, head, out.phrase)];
  if (toy != kNone) out.phrase = joined(words, hits[head].begin - 1, hits[head].end);
  for (const KnownPart& part : out.object->parts)
    out.parts.push_back({&table.materials[part.material], part.share, part.moves, nullptr});
  const Given given = toy == kNone ? given_material(table, words, hits, head) : Given();
  if (given.material) replace_material(given, out);
  return out;
}

PriorMatch match_material(const KnownMaterial& material) {
  PriorMatch out;
  out.parts.push_back({&material, 1, true, nullptr});
  out.phrase = material.name;
  out.certainty = 1;
  return out;
}

}  // namespace pliant
