#include "host/evaluate/brdf.hpp"

#include "host/evaluate/evaluate.hpp"

namespace brdfit {

const std::vector<std::string>& Brdf::channels() const {
    return measured_ ? measured_->channels() : material_->channels;
}

bool Brdf::isotropic() const {
    return measured_ ? measured_->isotropic() : material_->isotropic();
}

std::vector<float> Brdf::evaluate(const Device& device, const Directions& directions,
                                  const ProgressFunction& progress) const {
    return measured_ ? measured_->evaluate(device, directions, progress)
                     : brdfit::evaluate(device, *material_, directions, progress);
}

} // namespace brdfit
