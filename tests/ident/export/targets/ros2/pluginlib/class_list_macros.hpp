// Stands in for ROS 2's header.
#pragma once
#define PLUGINLIB_EXPORT_CLASS(derived, base) \
  static_assert(std::is_base_of<base, derived>::value, "a plugin of this base");
