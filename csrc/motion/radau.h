/* Constants of collocation on the Radau nodes; radau.c describes them. */
#ifndef AOI_RADAU_H
#define AOI_RADAU_H

#include "law/law.h"

enum { AOI_RADAU_MOMENTS = 13, AOI_EDGE_CHECKS = 10 };

extern const double aoi_radau_node[AOI_NODES];
extern const double aoi_radau_to_legendre[AOI_NODES][AOI_NODES];
extern const double aoi_radau_series[2 * AOI_RADAU_MOMENTS][AOI_NODES];
extern const double aoi_radau_on_part[AOI_NODES][AOI_NODES][AOI_NODES];
extern const double aoi_radau_slope_at_node[AOI_NODES + 1][AOI_NODES];
extern const double aoi_radau_edge_point[3][AOI_NODES];
extern const double aoi_radau_indentation_at_edge[2][AOI_NODES + 1][AOI_NODES];
extern const double aoi_radau_edge_projection[2][AOI_NODES][AOI_NODES];
extern const double aoi_radau_check_point[3][AOI_EDGE_CHECKS];
extern const double aoi_radau_check_weight[3][AOI_EDGE_CHECKS];

#endif
