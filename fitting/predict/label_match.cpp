#include "fitting/predict/label_match.h"

#include <algorithm>
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

bool one_of(const std::string& group, std::initializer_list<const char*> groups) {
  return std::any_of(groups.begin(), groups.end(), [&](const char* other) { return group == other; });
}

/// Whether "X of material" says what X is made of, not what it holds.
bool builds(const std::string& group) {
  return !one_of(group, {"food", "plant", "tissue", "liquid", "granular", "gel"});
}
/// Whether a figure of such a material is called by what it shows: a bronze rose.
bool carves(const std::string& group) {
  return one_of(group, {"wood", "metal", "stone", "ceramic", "glass", "plastic", "rubber", "mineral", "wax", "paper"});
}
/// Animals are shown in softer things too: a plush elephant, a chocolate bunny.
bool shows_animals(const std::string& group) {
  return carves(group) || one_of(group, {"textile", "leather", "foam", "food", "gel", "dough"});
}
bool covers(const std::string& group) { return one_of(group, {"textile", "leather"}); }

/// The material that the label gives its head; `stated` when it says so with "of".
size_t given_material(const MaterialTable& table, const std::vector<Hit>& hits, size_t head, bool& stated) {
  stated = false;
  if (head > 0 && hits[head - 1].segment == hits[head].segment && hits[head - 1].material != kNone)
    return hits[head - 1].material;
  for (size_t i = head + 1; i < hits.size(); ++i) {
    const Hit& hit = hits[i];
    const bool links = hit.link == "of" || hit.link == "from" || hit.link == "made" || hit.link == ",";
    if (hit.segment == hits[head].segment || !links || hit.material == kNone) continue;
    if (!builds(table.materials[hit.material].group)) continue;
    stated = hit.link != ",";
    return hit.material;
  }
  return kNone;
}

/// Gives the object's parts the material that the label names.
void replace_material(const KnownMaterial& material, bool stated, PriorMatch& match) {
  const std::vector<KnownPart>& known = match.object->parts;
  std::vector<MatchedPart>& parts = match.parts;
  const bool some = std::any_of(known.begin(), known.end(), [](auto& part) { return part.replaceable; });
  const bool animal =
      !some && std::any_of(parts.begin(), parts.end(), [](auto& part) { return part.material->group == "tissue"; });
  const bool shown = stated || (animal ? shows_animals(material.group) : carves(material.group));
  bool changed = false;
  for (size_t i = 0; i < parts.size(); ++i) {
    const bool fits = some ? known[i].replaceable : shown;
    // A leather sofa has a leather cover, not a leather frame.
    const bool cover = !stated && !animal && covers(material.group) && !covers(parts[i].material->group);
    if (!fits || cover) continue;
    parts[i].instead_of = parts[i].material;
    parts[i].material = &material;
    changed = true;
  }
  match.figure = animal && changed;
  if (!changed) match.unused = material.name;
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
  out.object = &table.objects[hits[head].object];
  for (const KnownPart& part : out.object->parts)
    out.parts.push_back({&table.materials[part.material], part.share, part.moves, nullptr});
  bool stated = false;
  const size_t given = given_material(table, hits, head, stated);
  if (given != kNone) replace_material(table.materials[given], stated, out);
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
