#include "segmentation/labelling/label_set.h"

#include <algorithm>
#include <set>
#include <tuple>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

const char* const kRest = "rest";

/// "chair 2" -> "chair", where there is a "chair" too: a name of its own may end in a number.
std::string without_number(const std::string& name, const std::map<uint32_t, std::string>& names) {
  const size_t end = name.find_last_not_of("0123456789");
  if (end == std::string::npos || end == 0 || end + 1 == name.size() || name[end] != ' ') return name;
  const std::string bare = name.substr(0, end);
  const bool known = std::any_of(names.begin(), names.end(), [&](const auto& entry) { return entry.second == bare; });
  return known ? bare : name;
}

}  // namespace

MaskSet gather_labels(const LabelSetOptions& options, const std::vector<int>& cameras,
                      const std::vector<LabelledPhoto>& photos) {
  CHECK(cameras.size() == photos.size());
  MaskSet masks;
  std::map<std::pair<std::string, int>, uint32_t> id_of;  // of the k-th thing of a name
  uint32_t last = 0;
  if (options.rest) masks.names[++last] = kRest;
  for (size_t v = 0; v < photos.size(); ++v) {
    std::vector<uint32_t> id = {options.rest ? 1u : 0u};
    std::map<std::string, int> times;
    for (const LabelledThing& thing : photos[v].things) {
      const int k = ++times[thing.name];
      uint32_t& known = id_of[{thing.name, k}];
      if (known == 0) {
        known = ++last;
        if (!thing.name.empty()) masks.names[known] = k == 1 ? thing.name : thing.name + " " + std::to_string(k);
      }
      id.push_back(known);
    }
    IdImage ids = photos[v].ids;
    for (uint32_t& pixel : ids.data) pixel = id[pixel];
    masks.views.push_back({cameras[v], std::move(ids)});
  }
  return masks;
}

uint32_t take_out_rest(MaskSet& masks) {
  for (const auto& [id, name] : masks.names) {
    if (name != kRest) continue;
    const uint32_t rest = id;
    masks.names.erase(rest);
    for (MaskSet::View& view : masks.views) std::replace(view.ids.data.begin(), view.ids.data.end(), rest, 0u);
    return rest;
  }
  return 0;
}

void put_back_rest(const MaskSet& before, uint32_t rest, MaskSet& after) {
  const std::vector<uint32_t> ids = after.ids();
  std::set<uint32_t> used(ids.begin(), ids.end());
  if (!used.insert(rest).second) {
    const uint32_t fresh = free_id(used);
    for (MaskSet::View& view : after.views) std::replace(view.ids.data.begin(), view.ids.data.end(), rest, fresh);
    if (const auto name = after.names.find(rest); name != after.names.end()) after.names[fresh] = name->second;
  }
  for (MaskSet::View& view : after.views) {
    const auto same = std::find_if(before.views.begin(), before.views.end(),
                                   [&](const MaskSet::View& v) { return v.camera == view.camera; });
    CHECK(same != before.views.end() && same->ids.data.size() == view.ids.data.size());
    for (size_t i = 0; i < view.ids.data.size(); ++i)
      if (view.ids.data[i] == 0 && same->ids.data[i] == rest) view.ids.data[i] = rest;
  }
  after.names[rest] = kRest;
}

std::map<uint32_t, std::string> carried_names(const MaskSet& before, const MaskSet& after) {
  std::map<uint32_t, std::map<std::string, size_t>> votes;  // "" = no name
  std::map<uint32_t, size_t> size;
  for (const MaskSet::View& view : after.views) {
    const auto same = std::find_if(before.views.begin(), before.views.end(),
                                   [&](const MaskSet::View& v) { return v.camera == view.camera; });
    if (same == before.views.end()) continue;
    CHECK(same->ids.data.size() == view.ids.data.size());
    std::map<std::pair<uint32_t, uint32_t>, size_t> pixels;
    for (size_t i = 0; i < view.ids.data.size(); ++i)
      if (view.ids.data[i] != 0) ++pixels[{view.ids.data[i], same->ids.data[i]}];
    for (const auto& [ids, count] : pixels) {
      size[ids.first] += count;
      const auto name = before.names.find(ids.second);
      votes[ids.first][name == before.names.end() ? "" : without_number(name->second, before.names)] += count;
    }
  }
  std::map<uint32_t, std::string> names;
  std::set<std::string> taken;
  std::vector<std::tuple<std::string, size_t, uint32_t>> named;
  for (const auto& [id, of_id] : votes) {
    if (const auto certain = after.names.find(id); certain != after.names.end()) {
      names.insert(*certain);
      taken.insert(certain->second);
      continue;
    }
    const auto most =
        std::max_element(of_id.begin(), of_id.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    if (!most->first.empty()) named.push_back({most->first, size[id], id});
  }
  std::sort(named.begin(), named.end(), [](const auto& a, const auto& b) {
    return std::tie(std::get<0>(a), std::get<1>(b), std::get<2>(a)) <
           std::tie(std::get<0>(b), std::get<1>(a), std::get<2>(b));
  });
  for (const auto& [name, pixels, id] : named) {
    std::string numbered = name;
    for (int k = 2; !taken.insert(numbered).second; ++k) numbered = name + " " + std::to_string(k);
    names[id] = numbered;
  }
  return names;
}

}  // namespace pliant
