/** The filter of the corridor, which two figures of the section show. */

import { signal } from "@preact/signals";
import { type Filter, start } from "./corridor";

export const COUNT = 24;
export const corridor = signal<Filter>(start(COUNT));
