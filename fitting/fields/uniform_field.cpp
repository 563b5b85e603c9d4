#include "fitting/fields/uniform_field.h"

namespace pliant {

ElasticSamples uniform_field(size_t count, double young, double poisson, double density) {
  validate_material("material", young, poisson, density);
  return ElasticSamples::homogeneous(count, young, poisson, density);
}

}  // namespace pliant
