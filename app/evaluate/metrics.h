#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace pliant {

/// {NAME: mean, NAME_median, NAME_std}; null without values.
void add_statistics(nlohmann::json& out, const std::string& name, const std::vector<double>& values);
double median(std::vector<double> values);

/// PSNR [dB] of a mean squared error of values in [0, 1], at most that of identical pictures, which is infinite and
/// counts as kPsnrOfIdentical.
constexpr double kPsnrOfIdentical = 100;
double capped_psnr(double mse);

/// The value of a key, in which the keys of nested objects are joined by a dot; null where there is none.
const nlohmann::json* find_value(const nlohmann::json& object, const std::string& key);

/// Pictures of a folder by name without extension.  Two pictures of one name are an Error{kInput}.
std::map<std::string, std::filesystem::path> pictures_of(const std::filesystem::path& folder);

/// Frequency [Hz] of the strongest oscillation of evenly sampled values: linear trend removed, Hann window, maximum of
/// the Fourier transform on a fine scan from one period in the record up to half the rate.  0 when nothing moves. Right
/// from about two periods in the record on; below, fit_oscillation finds what this misses.
double dominant_frequency(const std::vector<double>& values, double rate);
/// Frequency [Hz] from the first to the last crossing of the mean, two crossings a period; 0 with fewer than 2.
double zero_crossing_frequency(const std::vector<double>& values, double rate);

}  // namespace pliant
