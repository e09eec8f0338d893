/** The sections of a dock: groups beside each other that belong together share one tab. */

export interface Grouped {
  readonly id: string;
  readonly title: string;
  readonly section?: string;
  readonly purpose?: string;
  readonly badge?: string | null;
}

export interface Section<G extends Grouped> {
  /** The id of its first group. */
  readonly id: string;
  readonly title: string;
  /** The titles of its groups; of a single group what it is for. */
  readonly hint: string | null;
  /** The badge of its first group that has one. */
  readonly badge: string | null;
  readonly groups: readonly G[];
}

/** The groups by sections, in their order. */
export function sectionsOf<G extends Grouped>(groups: readonly G[]): readonly Section<G>[] {
  const runs: G[][] = [];
  for (const group of groups) {
    const last = runs.at(-1);
    if (last && group.section !== undefined && last[0]?.section === group.section) last.push(group);
    else runs.push([group]);
  }
  return runs.map((run) => {
    const first = run[0] as G;
    const isSingle = run.length === 1;
    return {
      id: first.id,
      title: isSingle ? first.title : (first.section ?? first.title),
      hint: isSingle ? (first.purpose ?? null) : run.map(({ title }) => title).join(", "),
      badge: run.find(({ badge }) => badge)?.badge ?? null,
      groups: run,
    };
  });
}
