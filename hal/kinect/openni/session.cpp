// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/openni/session.hpp"

#include <OpenNI.h>
#include <fmt/format.h>

#include <algorithm>

#include "hal/lease.hpp"

namespace g3d::hal::kinect::openni {
namespace {

Lease openni_lease;

}  // namespace

std::string openni_error() {
  std::string text = ::openni::OpenNI::getExtendedError();
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ';');
  return text;
}

Result<std::unique_ptr<Session>> Session::begin(Driver driver, ImageSink& tap, const Clock& clock) {
  if (!openni_lease.try_take()) {
    return Error{Reason::no_capacity, "another part of this program has a Kinect or an .oni file open already"};
  }
  const std::uint64_t exceptions = driver_exceptions();
  select_driver(driver);
  if (::openni::OpenNI::initialize() != ::openni::STATUS_OK) {
    // What it began has to be ended, or the next try would find it begun.
    const std::string why = driver_exceptions() != exceptions ? last_driver_exception() : openni_error();
    ::openni::OpenNI::shutdown();
    openni_lease.give_back();
    return Error{Reason::unsupported,
                 fmt::format("the Kinect's driver could not start: {}; is there USB on this machine?", why)};
  }
  set_image_tap(&tap, &clock);
  return std::unique_ptr<Session>(new Session);
}

Session::~Session() {
  set_image_tap(nullptr, nullptr);
  ::openni::OpenNI::shutdown();
  openni_lease.give_back();
}

}  // namespace g3d::hal::kinect::openni
