import './core/api';
