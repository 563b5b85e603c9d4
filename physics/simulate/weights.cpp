#include "physics/simulate/weights.h"

namespace pliant {
namespace {

/// Calls visit(interaction, particle, its share of the weight) for all weights and the particles of their regions.
template <class T, class Visit>
void for_weights(const BasicParticles<T>& particles, const std::vector<Interaction>& interactions, Visit&& visit) {
  for (size_t k = 0; k < interactions.size(); ++k) {
    if (interactions[k].type != InteractionType::kWeight) continue;
    std::vector<size_t> touched;
    double volume = 0;
    for (size_t i = 0; i < particles.size(); ++i) {
      if (!interactions[k].region.contains(particles.position[i].template cast<double>())) continue;
      touched.push_back(i);
      volume += particles.volume[i];
    }
    for (const size_t i : touched) visit(k, i, particles.volume[i] / volume);
  }
}

}  // namespace

template <class T>
std::vector<T> masses_with_weights(const BasicParticles<T>& particles, const std::vector<Interaction>& interactions) {
  std::vector<T> mass = particles.mass;
  for_weights(particles, interactions,
              [&](size_t k, size_t i, double share) { mass[i] += static_cast<T>(share * interactions[k].mass); });
  return mass;
}

template <class T>
std::vector<double> weights_adjoint(const BasicParticles<T>& particles, const std::vector<Interaction>& interactions,
                                    const std::vector<T>& adj_mass) {
  std::vector<double> adj_weight(interactions.size());
  for_weights(particles, interactions,
              [&](size_t k, size_t i, double share) { adj_weight[k] += share * static_cast<double>(adj_mass[i]); });
  return adj_weight;
}

template std::vector<float> masses_with_weights(const BasicParticles<float>&, const std::vector<Interaction>&);
template std::vector<double> masses_with_weights(const BasicParticles<double>&, const std::vector<Interaction>&);
template std::vector<double> weights_adjoint(const BasicParticles<float>&, const std::vector<Interaction>&,
                                             const std::vector<float>&);
template std::vector<double> weights_adjoint(const BasicParticles<double>&, const std::vector<Interaction>&,
                                             const std::vector<double>&);

}  // namespace pliant
