// Numbers of a result by the members that lead to them: figure<&Result::size, &Parts::Size::rate>.
#pragma once

#include "experiments/results/result.hpp"

namespace cvr::experiments {

template <auto... Members, class T>
Figure number_in(const T& value);

template <auto First, auto... Rest, class T>
Figure number_behind(const T& part) {
  return number_in<Rest...>(part.*First);
}

template <auto... Members, class T>
Figure number_in(const T& value) {
  if constexpr (requires { value.has_value(); })
    return value ? number_in<Members...>(*value) : std::nullopt;
  else if constexpr (sizeof...(Members) == 0)
    return static_cast<double>(value);
  else
    return number_behind<Members...>(value);
}

/// None where it, or a part on the way to it, is absent or null.
template <auto... Members>
Figure figure(const Result& result) {
  return number_in<Members...>(result);
}
using ReadFigure = Figure (*)(const Result&);

}  // namespace cvr::experiments
