#pragma once

#include <vector>

#include "physics/mpm/particles.h"
#include "physics/simulate/interaction.h"

namespace pliant {

/// [N] kg, masses of the particles with the weights that hang on them.  A weight is spread over the particles of its
/// region in proportion to their volume, so that it moves with them and stiffens nothing.  Its gravity pulls there too.
template <class T>
std::vector<T> masses_with_weights(const BasicParticles<T>& particles, const std::vector<Interaction>& interactions);

/// [interactions] derivative of a scalar by the mass of each weight [1/kg], from that by the masses above; 0 for all
/// other interactions.
template <class T>
std::vector<double> weights_adjoint(const BasicParticles<T>& particles, const std::vector<Interaction>& interactions,
                                    const std::vector<T>& adj_mass);

extern template std::vector<float> masses_with_weights(const BasicParticles<float>&, const std::vector<Interaction>&);
extern template std::vector<double> masses_with_weights(const BasicParticles<double>&, const std::vector<Interaction>&);
extern template std::vector<double> weights_adjoint(const BasicParticles<float>&, const std::vector<Interaction>&,
                                                    const std::vector<float>&);
extern template std::vector<double> weights_adjoint(const BasicParticles<double>&, const std::vector<Interaction>&,
                                                    const std::vector<double>&);

}  // namespace pliant
