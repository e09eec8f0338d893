"""The types of messages of which a picture can be made (:mod:`mapper.io.contents.pictures`)."""

CAMERAS = frozenset({"sensor_msgs/Image", "sensor_msgs/CompressedImage"})
PICTURED = CAMERAS | {"sensor_msgs/PointCloud2"}
