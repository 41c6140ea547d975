import { describe, expect, it } from 'vitest';
import { findPage, firstPath, matchPath, mayOpen, pathOf, pathTo, type PageEntry } from './router';

const entry = (path: string, roles: PageEntry['roles'] = ['operator'], title: PageEntry['title'] = null): PageEntry => ({
  path,
  roles,
  title,
  load: () => Promise.reject(new Error('not opened here')),
});

describe('addresses', () => {
  it('give what stands for the named parts', () => {
    expect(matchPath('/scans/:scan/glasses', '/scans/s-7/glasses')).toEqual({ scan: 's-7' });
  });
  it('are decoded once', () => {
    expect(matchPath('/customers/:customer', '/customers/a%2Fb')).toEqual({ customer: 'a/b' });
  });
  it('of another length, with an empty part or a lone percent sign fit nothing', () => {
    expect(matchPath('/scans/:scan', '/scans')).toBeNull();
    expect(matchPath('/scans/:scan', '/scans/')).toBeNull();
    expect(matchPath('/scans/:scan', '/scans/%')).toBeNull();
  });
  it('come from the hash without what is behind a question mark', () => {
    expect(pathOf('#/scans/7?view=front')).toBe('/scans/7');
    expect(pathOf('')).toBe('/');
  });
  it('are made from a pattern and back again', () => {
    expect(matchPath('/scans/:scan', pathTo('/scans/:scan', { scan: 'ü/1' }))).toEqual({ scan: 'ü/1' });
  });
});

describe('pages', () => {
  const pages = [entry('/scans/:scan'), entry('/scans/new', ['operator'], () => 'New'), entry('/users', ['admin'], () => 'Users')];
  it('with an exact address go before patterns', () => {
    expect(findPage(pages, '/scans/new')?.entry.path).toBe('/scans/new');
    expect(findPage(pages, '/scans/8')?.parameters).toEqual({ scan: '8' });
    expect(findPage(pages, '/nowhere')).toBeNull();
  });
  it('are opened by their roles only', () => {
    const users = pages[2] as PageEntry;
    expect(mayOpen(users, 'admin')).toBe(true);
    for (const other of ['none', 'operator', 'technician'] as const) expect(mayOpen(users, other)).toBe(false);
  });
  it('begin for each role with the first of its navigation', () => {
    expect(firstPath(pages, 'operator')).toBe('/scans/new');
    expect(firstPath(pages, 'admin')).toBe('/users');
    expect(firstPath(pages, 'technician')).toBeNull();
  });
});
