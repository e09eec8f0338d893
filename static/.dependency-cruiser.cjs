/**
 * The layers of src/: each imports what stands below it, never what stands above or beside it.
 *
 * `npm run check` holds the tree to it. TypeScript is read by swc, since TypeScript 7 has no interface for programs that
 * dependency-cruiser knows; types that are imported count as imports.
 */

/** From the top down; folders on one line do not import each other. */
const LAYERS = [["pages"], ["tools"], ["lessons"], ["store"], ["render"], ["grid"], ["wire"], ["ui"], ["style"]];

const inside = (folders) => `^src/(${folders.join("|")})/`;

const layerRules = LAYERS.flatMap((layer, i) =>
  layer.map((folder) => ({
    name: `${folder}-imports-only-lower-layers`,
    comment: `src/${folder} imports from itself and from the layers below it.`,
    severity: "error",
    from: { path: inside([folder]) },
    to: { path: "^src/", pathNot: inside([folder, ...LAYERS.slice(i + 1).flat()]) },
  })),
);

/** @type {import("dependency-cruiser").IConfiguration} */
module.exports = {
  forbidden: [
    ...layerRules,
    {
      name: "no-circular",
      comment: "No file imports itself by way of others.",
      severity: "error",
      from: {},
      to: { circular: true },
    },
    {
      name: "exhaustive",
      comment: "Every file is in the folder of a layer.",
      severity: "error",
      from: { path: "^src/", pathNot: inside(LAYERS.flat()) },
      to: {},
    },
    {
      name: "no-orphans",
      comment: "Every file imports something or is imported.",
      severity: "error",
      from: { path: "^src/", orphan: true, pathNot: "\\.(css|svg|d\\.ts)$" },
      to: {},
    },
    {
      name: "resolvable",
      comment: "Every import leads to a file or a package.",
      severity: "error",
      from: {},
      to: { couldNotResolve: true },
    },
  ],
  options: {
    parser: "swc",
    tsConfig: { fileName: "tsconfig.json" },
    doNotFollow: { path: "node_modules" },
    enhancedResolveOptions: { exportsFields: ["exports"], conditionNames: ["import", "types", "default"] },
  },
};
